// Beside trimesh's viewer, whose names scene, camera, renderer and render are used here.
(() => {
  const FAINT = 0.12;
  const NAMED = ["f", "p", "e", "view"];  // others have their names when lit
  // What is nearer than this share of the distance hides a name; a piece's faces lie about it.
  const BEFORE = { p: 0.97 }, ANY = 0.998;
  // Is not there, but lit round what is: that stays as it is.
  const ABOUT = ["unseen"];
  const GLOWS = ["e", "v", "unseen"];  // thin as it is
  // A face shows its rim itself: `userData.rim` is there once it is lit.
  const HAZE = 4;  // times as dense as it is else
  const MOST = 300;  // names, the nearest: more have no room, and a ray for each takes time
  let lit = [], shown = ["f"], some = false;
  const meshes = () => {
    const found = [];
    scene.traverse((one) => { if (one.isMesh) found.push(one); });
    return found;
  };
  const kind = (one) => one.name.replace(/\d+$/, "");
  function show() {
    const all = meshes();
    some = all.some((one) => lit.includes(one.name) && !ABOUT.includes(kind(one)));
    for (const one of all) {
      if (!one.userData.own) {
        one.material = one.material.clone();
        one.material.side = THREE.DoubleSide;
        one.material.polygonOffset = kind(one) === "f";  // a piece's side is drawn on its faces
        one.material.polygonOffsetFactor = one.material.polygonOffsetUnits = 2;
        one.userData.own = true;
      }
      const on = lit.includes(one.name);
      const soft = kind(one) === "unseen" || kind(one) === "p";
      const faint = some && !on && !ABOUT.includes(kind(one));
      one.visible = on || shown.includes(kind(one)) && !one.userData.rim;
      one.material.transparent = soft || faint;
      one.material.opacity = faint ? FAINT : on && kind(one) === "unseen" ? HAZE : 1;
      one.material.depthWrite = !(faint || kind(one) === "unseen");
      one.material.emissive.setHex(!on ? 0x000000 : GLOWS.includes(kind(one)) ? 0xd9730d : 0x553300);
      one.material.needsUpdate = true;
    }
    render();
    write();
  }

  // Names, which face whoever looks: each where its thing stands, unless something is before it,
  // and none on another.
  const style = document.createElement("style");
  style.textContent = `body { overflow: hidden; }
    .name { position: absolute; left: 0; top: 0; padding: 0 4px; border-radius: 4px;
      font: 600 12px/16px system-ui, sans-serif; color: #1c2024; background: rgb(255 255 255 / .8);
      pointer-events: none; visibility: hidden; white-space: nowrap; }
    @media (prefers-color-scheme: dark) {
      .name { color: #f2f4f6; background: rgb(21 24 27 / .8); } }`;
  document.head.append(style);
  const tags = new Map();
  function tag(one) {
    if (!tags.has(one.name)) {
      const made = document.createElement("span");
      made.className = "name";
      made.textContent = one.name;
      document.body.append(made);
      tags.set(one.name, { made, width: made.offsetWidth, height: made.offsetHeight });
    }
    return tags.get(one.name);
  }
  function write() {
    scene.updateMatrixWorld();
    camera.updateMatrixWorld();
    for (const { made } of tags.values()) made.style.visibility = "hidden";
    const there = meshes().filter((one) => one.visible);
    const hiding = there.filter((one) =>
      ["f", "p"].includes(kind(one)) && (!some || lit.includes(one.name)));
    const taken = [];
    there.filter((one) => lit.includes(one.name) || !some && NAMED.includes(kind(one)))
      .filter((one) => kind(one) !== "unseen")
      .map((one) => {
        const { at } = one.userData;
        if (!one.geometry.boundingSphere) one.geometry.computeBoundingSphere();
        const place = at ? new THREE.Vector3(...at) : one.geometry.boundingSphere.center.clone();
        one.localToWorld(place);
        return { one, place, away: place.distanceTo(camera.position) };
      })
      .sort((one, other) => lit.includes(other.one.name) - lit.includes(one.one.name)
        || one.away - other.away)
      .slice(0, MOST)
      .forEach(({ one, place, away }) => {
        const seen = place.clone().project(camera);
        if (Math.max(Math.abs(seen.x), Math.abs(seen.y), Math.abs(seen.z)) > 1) return;
        const towards = place.clone().sub(camera.position).normalize();
        const hits = new THREE.Raycaster(camera.position, towards).intersectObjects(hiding, false);
        const own = hits.find((hit) => hit.object === one);
        const least = (BEFORE[kind(one)] || ANY) * (own ? own.distance : away);
        if (hits.length && hits[0].distance < least) return;
        const { made, width, height } = tag(one);
        const left = (1 + seen.x) / 2 * innerWidth - width / 2;
        const top = (1 - seen.y) / 2 * innerHeight - height / 2;
        const free = [0, 1, -1].map((lines) => top + lines * (height + 1)).find((y) =>
          taken.every((box) => left + width < box.left || box.left + box.width < left
            || y + height < box.top || box.top + box.height < y));
        if (free === undefined) return;
        taken.push({ left, top: free, width, height });
        made.style.transform = `translate(${left}px, ${free}px)`;
        made.style.visibility = "visible";
      });
  }

  // The page may not yet have listened when this was posted: it asks once it does.
  let state = {};
  function say(what) {
    state = what;
    parent.postMessage(state, "*");
  }
  addEventListener("message", (event) => {
    if (event.source !== parent || !event.data) return;
    if (event.data.ask) {
      parent.postMessage(state, "*");
      return;
    }
    if (event.data.lit) lit = event.data.lit;
    if (event.data.shown) shown = event.data.shown;
    if (event.data.ground !== undefined) scene.background = new THREE.Color(event.data.ground);
    if (event.data.turn) {
      const { about, by } = event.data.turn;
      // Across is to the right of whoever looks, wherever from; the camera's up turns along, or it
      // would flip beyond the poles.
      const axis = about === "up" ? new THREE.Vector3(0, 1, 0)
        : new THREE.Vector3(1, 0, 0).applyQuaternion(camera.quaternion);
      camera.position.sub(controls.target).applyAxisAngle(axis, by).add(controls.target);
      camera.up.applyAxisAngle(axis, by);
      controls.update();
    }
    show();
  });
  let down = null;
  addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; }, true);
  addEventListener("pointerup", (event) => {
    if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
    const at = new THREE.Vector2(
      2 * event.clientX / innerWidth - 1, 1 - 2 * event.clientY / innerHeight);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, camera);
    const hit = ray.intersectObjects(meshes().filter((one) => one.visible && kind(one) !== "unseen"));
    parent.postMessage({ picked: hit.length ? hit[0].object.name : "" }, "*");
  }, true);
  const canvas = document.createElement("canvas");
  if (!canvas.getContext("webgl2") && !canvas.getContext("webgl")) {
    say({ blank: true });
    return;
  }
  const wait = setInterval(() => {
    if (typeof controls === "undefined" || !controls || !meshes().length) return;
    clearInterval(wait);
    scene.add(new THREE.AmbientLight(0xffffff, 0.7));
    controls.target.set(0, 0, 0);  // the viewer looks at the middle of all, cameras too
    controls.update();
    controls.addEventListener("change", write);
    addEventListener("resize", write);
    show();
    say({ ready: true });
  }, 50);
})();
