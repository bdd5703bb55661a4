import{a as n,va as o}from"./chunk-OHQ724HE.js";function e({text:r}){return o(n,{children:r.split("`").map((t,d)=>d%2?o("code",{children:t},d):t)})}export{e as a};
