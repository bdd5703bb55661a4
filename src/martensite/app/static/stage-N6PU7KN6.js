import{b as a}from"./chunk-DEYVCWL3.js";import"./chunk-7ODEMVVK.js";import"./chunk-43NZMJWU.js";export{a as Stage};
