import{b as a}from"./chunk-WO2YTHB2.js";import"./chunk-REN3FACO.js";import"./chunk-43NZMJWU.js";export{a as Stage};
