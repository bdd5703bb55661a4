import{b as a}from"./chunk-JL4HMIWH.js";import"./chunk-REN3FACO.js";import"./chunk-R32IY5BT.js";export{a as Stage};
