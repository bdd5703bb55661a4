import{g as n}from"./chunk-RLH3V6A7.js";function e(){return n("h1",{children:"Identify"})}export{e as Page};
