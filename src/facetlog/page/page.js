"use strict";
(() => {
  const model = document.getElementById("model");
  const about = document.getElementById("lit");
  const clear = document.getElementById("clear");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const TURNS = { left: ["up", -0.3], right: ["up", 0.3], up: ["across", -0.3], down: ["across", 0.3] };

  function tell(what) { if (model && model.contentWindow) model.contentWindow.postMessage(what, "*"); }
  function shown() { return [...document.querySelectorAll(".kind:checked")].map((box) => box.value); }
  function dress() {
    document.body.classList.toggle("pieces", shown().includes("p"));
    tell({ shown: shown(), ground: dark.matches ? 0x1f2428 : 0xffffff });
  }

  function light(names, line) {
    document.querySelectorAll(".line.on").forEach((one) => one.classList.remove("on"));
    if (line) line.classList.add("on");
    document.querySelectorAll("svg [data-name]").forEach((one) =>
      one.classList.toggle("on", names.includes(one.dataset.name)));
    tell({ lit: names });
    const said = [...new Set(names.map((name) =>
      name.startsWith("unseen") ? "what nobody saw" : name))];
    if (about) about.textContent = said.length ? `Lit: ${said.join(", ")}` : "Nothing is lit.";
    if (clear) clear.hidden = !names.length;
  }

  function without3D() {
    const why = document.createElement("p");
    why.id = "without-3d";
    why.textContent = "This browser shows nothing in 3-D, for it has no WebGL or that is turned off."
      + " Faces light up in the pictures all the same.";
    model.replaceWith(why);
    document.querySelectorAll(".kind, [data-turn]").forEach((one) => { one.disabled = true; });
  }

  addEventListener("message", (event) => {
    if (!model || event.source !== model.contentWindow) return;
    if (event.data.ready) dress();
    if (event.data.blank) without3D();
    if (event.data.picked !== undefined) light(event.data.picked ? [event.data.picked] : []);
  });
  tell({ ask: true });  // what it posted before anybody listened
  dark.addEventListener("change", dress);
  document.querySelectorAll(".kind").forEach((box) => box.addEventListener("change", dress));
  if (clear) clear.addEventListener("click", () => light([]));
  document.querySelectorAll("[data-turn]").forEach((button) => button.addEventListener("click", () => {
    const [about, by] = TURNS[button.dataset.turn];
    tell({ turn: { about, by } });
  }));
  document.querySelectorAll(".line").forEach((line) => line.addEventListener("click", () =>
    line.classList.contains("on") ? light([]) : light(line.dataset.names.split(" "), line)));

  const large = document.getElementById("large");
  document.querySelectorAll(".picture").forEach((button) => button.addEventListener("click", () => {
    const place = large.querySelector("div");
    place.replaceChildren(button.querySelector("svg").cloneNode(true));
    place.querySelectorAll("path").forEach((one) =>
      one.addEventListener("click", () => light([one.dataset.name])));
    large.setAttribute("aria-label", button.querySelector("svg").getAttribute("aria-label"));
    large.showModal();
  }));
})();
