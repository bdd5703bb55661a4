import{b as a}from"./chunk-25IJDOXD.js";import"./chunk-7ODEMVVK.js";import"./chunk-R32IY5BT.js";export{a as Stage};
