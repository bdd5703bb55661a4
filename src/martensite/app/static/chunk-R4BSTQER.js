import{d as o}from"./chunk-JRBHR5S4.js";import{d as n}from"./chunk-S7PLUQWF.js";function e({text:r}){return o(n,{children:r.split("`").map((t,d)=>d%2?o("code",{children:t},d):t)})}export{e as a};
