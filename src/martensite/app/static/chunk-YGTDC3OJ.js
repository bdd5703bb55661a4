import{a as n,va as o}from"./chunk-YOBHD5N6.js";function e({text:r}){return o(n,{children:r.split("`").map((t,d)=>d%2?o("code",{children:t},d):t)})}export{e as a};
