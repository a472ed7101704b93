// Beside trimesh's viewer, whose names scene, camera, renderer and render are used here.
(() => {
  const FAINT = 0.12;
  let lit = [], shown = ["f"];
  const meshes = () => {
    const found = [];
    scene.traverse((one) => { if (one.isMesh) found.push(one); });
    return found;
  };
  const kind = (one) => one.name.replace(/\d+$/, "");
  function show() {
    const all = meshes();
    const some = all.some((one) => lit.includes(one.name));  // edges and vertices have no mesh
    for (const one of all) {
      if (!one.userData.own) {
        one.material = one.material.clone();
        one.material.side = THREE.DoubleSide;
        one.userData.own = true;
      }
      const on = lit.includes(one.name);
      const soft = kind(one) === "unseen" || kind(one) === "p";
      const faint = some && !on;
      one.visible = shown.includes(kind(one)) || on;
      one.material.transparent = soft || faint;
      one.material.opacity = faint ? FAINT : 1;
      one.material.depthWrite = !(faint || kind(one) === "unseen");
      one.material.emissive.setHex(on ? 0x553300 : 0x000000);
      one.material.needsUpdate = true;
    }
    render();
  }
  addEventListener("message", (event) => {
    if (event.source !== parent || !event.data) return;
    if (event.data.lit) lit = event.data.lit;
    if (event.data.shown) shown = event.data.shown;
    if (event.data.ground !== undefined) scene.background = new THREE.Color(event.data.ground);
    if (event.data.turn) {
      camera.position.sub(controls.target)
        .applyAxisAngle(new THREE.Vector3(...event.data.turn.axis), event.data.turn.by)
        .add(controls.target);
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
    parent.postMessage({ blank: true }, "*");
    return;
  }
  const wait = setInterval(() => {
    if (typeof controls === "undefined" || !controls || !meshes().length) return;
    clearInterval(wait);
    controls.target.set(0, 0, 0);  // the viewer looks at the middle of all, cameras too
    controls.update();
    show();
    parent.postMessage({ ready: true }, "*");
  }, 50);
})();
