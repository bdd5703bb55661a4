import{b as a}from"./chunk-LL53UIJW.js";import"./chunk-REN3FACO.js";import"./chunk-43NZMJWU.js";export{a as Stage};
