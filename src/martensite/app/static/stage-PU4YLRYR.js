import{b as a}from"./chunk-A6RXWLTN.js";import"./chunk-7ODEMVVK.js";import"./chunk-43NZMJWU.js";export{a as Stage};
