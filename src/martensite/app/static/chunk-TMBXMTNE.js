import{va as r}from"./chunk-YOBHD5N6.js";function n({kind:e,children:o}){return r("p",{class:`message ${e}`,role:e==="error"?"alert":"status",children:o})}export{n as a};
