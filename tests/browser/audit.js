// What is wrong with a page for those who cannot see, point or tell colours well. Gives sentences.
() => {
  const ARROW = 14; // room for the arrow of a select [px]
  const faults = [];
  const shownBox = (element) => {
    const style = getComputedStyle(element);
    const box = element.getBoundingClientRect();
    return style.visibility === "visible" && box.width > 0 && box.height > 0 && box.right > 0 ? box : null;
  };
  const called = (element) => {
    const id = element.id ? `#${element.id}` : "";
    const kind = typeof element.className === "string" && element.className ? `.${element.className.split(/\s+/).join(".")}` : "";
    return `<${element.tagName.toLowerCase()}${id}${kind}> “${(element.textContent ?? "").trim().slice(0, 30)}”`;
  };

  // names of elements
  const ids = [...document.querySelectorAll("[id]")].map((one) => one.id);
  for (const id of new Set(ids.filter((one, k) => ids.indexOf(one) !== k))) faults.push(`two elements have the id ${id}`);
  for (const name of ["aria-labelledby", "aria-describedby", "aria-controls", "for"]) {
    for (const element of document.querySelectorAll(`[${name}]`)) {
      for (const id of element.getAttribute(name).split(/\s+/)) {
        const folded = name === "aria-controls" && element.getAttribute("aria-expanded") === "false";
      if (id && !folded && !document.getElementById(id)) faults.push(`${called(element)} refers by ${name} to ${id}, which is not there`);
      }
    }
  }
  for (const image of document.querySelectorAll("img:not([alt])")) faults.push(`${called(image)} has no alt`);
  for (const positive of document.querySelectorAll("[tabindex]")) {
    if (positive.tabIndex > 0) faults.push(`${called(positive)} has a place of its own in the order of Tab`);
  }

  // headings
  const levels = [...document.querySelectorAll("h1, h2, h3, h4, h5, h6")].filter(shownBox);
  if (levels.filter((one) => one.tagName === "H1").length !== 1) faults.push("there must be one h1");
  levels.reduce((before, one) => {
    const level = Number(one.tagName[1]);
    if (level > before + 1) faults.push(`${called(one)} comes after a heading of level ${before}`);
    return level;
  }, 1);
  if (!document.documentElement.lang) faults.push("the language is not said");
  if (document.querySelectorAll("main").length !== 1) faults.push("there must be one main");

  // contrast
  const numbers = (text) => {
    const canvas = (window.auditCanvas ??= new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true }));
    canvas.clearRect(0, 0, 1, 1);
    canvas.fillStyle = text;
    canvas.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  };
  const known = new Map();
  const colour = (text) => known.get(text) ?? (known.set(text, numbers(text)), known.get(text));
  const over = (top, below) => [0, 1, 2].map((k) => top[k] * top[3] + below[k] * (1 - top[3])).concat(1);
  const behind = (element) => {
    const layers = [];
    for (let one = element; one; one = one.parentElement) {
      const style = getComputedStyle(one);
      if (style.backgroundImage !== "none") return null;
      layers.push(colour(style.backgroundColor));
      if (layers.at(-1)[3] === 1) break;
    }
    return layers.reverse().reduce((below, top) => over(top, below), [255, 255, 255, 1]);
  };
  const light = (rgb) => {
    const [r, g, b] = rgb.slice(0, 3).map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const opacity = (element) => (element ? Number(getComputedStyle(element).opacity) * opacity(element.parentElement) : 1);
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const seen = new Set();
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement;
    if (!walker.currentNode.data.trim() || seen.has(element) || element.closest("noscript, script, style, option, svg")) continue;
    seen.add(element);
    if (!shownBox(element) || element.closest(":disabled, [aria-disabled=true], [aria-hidden=true]")) continue;
    const style = getComputedStyle(element);
    const back = behind(element);
    if (!back) continue;
    const ink = [...colour(style.color)];
    ink[3] *= opacity(element);
    const [one, other] = [light(over(ink, back)), light(back)].sort((a, b) => b - a);
    const ratio = (one + 0.05) / (other + 0.05);
    const size = parseFloat(style.fontSize);
    const large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    if (ratio < (large ? 3 : 4.5)) faults.push(`${called(element)} has a contrast of ${ratio.toFixed(2)}`);
  }

  // what is touched
  for (const control of document.querySelectorAll("button, select, input:not([type=hidden]), textarea, summary, nav a, [role=tab], [role=slider]")) {
    const target = control.matches("[type=checkbox], [type=radio], [type=file]") ? (control.closest("label") ?? control.labels?.[0] ?? control) : control;
    const box = shownBox(target);
    if (!box || box.width <= 1 || box.top > document.documentElement.scrollHeight) continue;
    if (box.height < 31.9 || box.width < 24) faults.push(`${called(target)} is ${box.width.toFixed(0)} by ${box.height.toFixed(0)} px`);
  }

  // layout and motion
  const root = document.documentElement;
  if (root.scrollWidth > root.clientWidth) faults.push(`the page is ${root.scrollWidth - root.clientWidth} px too wide`);
  const pen = window.auditCanvas ?? new OffscreenCanvas(1, 1).getContext("2d");
  for (const choice of document.querySelectorAll("select")) {
    if (!shownBox(choice) || choice.closest(".select")) continue; // its text breaks into lines
    const style = getComputedStyle(choice);
    pen.font = style.font;
    const room = choice.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight) - ARROW;
    if (pen.measureText(choice.selectedOptions[0]?.text ?? "").width > room) faults.push(`${called(choice)} cuts “${choice.selectedOptions[0].text}”`);
  }
  for (const moving of document.getAnimations()) {
    if (moving.playState === "running") faults.push(`${called(moving.effect.target)} moves`);
  }
  return [...new Set(faults)];
}
