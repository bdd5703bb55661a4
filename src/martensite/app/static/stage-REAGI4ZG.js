import{b as a}from"./chunk-3KBWGNMY.js";import"./chunk-43NZMJWU.js";import"./chunk-7ODEMVVK.js";export{a as Stage};
