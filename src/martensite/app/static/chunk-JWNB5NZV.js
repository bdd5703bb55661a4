import{ta as r}from"./chunk-ORVMHUB3.js";function n({kind:e,children:o}){return r("p",{class:`message ${e}`,role:e==="error"?"alert":"status",children:o})}export{n as a};
