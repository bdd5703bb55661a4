import{va as r}from"./chunk-BWCPN36S.js";function n({kind:e,children:o}){return r("p",{class:`message ${e}`,role:e==="error"?"alert":"status",children:o})}export{n as a};
