import{a as n,ta as o}from"./chunk-ORVMHUB3.js";function e({text:r}){return o(n,{children:r.split("`").map((t,d)=>d%2?o("code",{children:t},d):t)})}export{e as a};
