import{b as a}from"./chunk-B4F7GJQI.js";import"./chunk-7ODEMVVK.js";import"./chunk-43NZMJWU.js";export{a as Stage};
