import{b as a}from"./chunk-WK6WV67O.js";import"./chunk-7ODEMVVK.js";import"./chunk-R32IY5BT.js";export{a as Stage};
