import{d as n,k as o}from"./chunk-YCLJUCYP.js";function e({text:r}){return o(n,{children:r.split("`").map((t,d)=>d%2?o("code",{children:t},d):t)})}export{e as a};
