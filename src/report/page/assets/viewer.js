"use strict";
// The part to turn: reads the GLB that the page holds, and draws it in place of the still picture.
(() => {
  const box = document.getElementById("part3d");
  const data = document.getElementById("part-glb");
  if (!box || !data) return;

  // The triangles of a GLB of ours: 12 bytes of header, then chunks of length, kind and bytes.
  function triangles(bytes) {
    const view = new DataView(bytes.buffer);
    const length = view.getUint32(12, true);
    const json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
    const start = 20 + length + 8;
    const array = (index) => {
      const { bufferView, byteOffset = 0, componentType, count, type } = json.accessors[index];
      const from = start + (json.bufferViews[bufferView].byteOffset || 0) + byteOffset;
      const kinds = { 5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
      const numbers = type === "VEC3" ? 3 * count : count;
      const Kind = kinds[componentType];
      return new Kind(bytes.buffer.slice(from, from + numbers * Kind.BYTES_PER_ELEMENT));
    };
    return json.meshes.flatMap((mesh) => mesh.primitives).map((primitive) => {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(array(primitive.attributes.POSITION), 3));
      geometry.setIndex(new THREE.BufferAttribute(array(primitive.indices), 1));
      // Edges of more than 25 degrees stay edges.
      return THREE.toCreasedNormals(geometry, Math.PI * 25 / 180);
    });
  }

  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  } catch (_) {
    return; // The still picture stays.
  }
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xffffff);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8c95a0, 1.6));
  const lamp = new THREE.DirectionalLight(0xffffff, 2.2);
  // The optical face comes first, and what is not polished after it.
  const materials = [
    new THREE.MeshStandardMaterial({ color: 0x9fb9d6, metalness: 0.35, roughness: 0.28 }),
    new THREE.MeshStandardMaterial({ color: 0xb4b8bd, metalness: 0.1, roughness: 0.8 }),
  ];
  const camera = new THREE.PerspectiveCamera(30, 4 / 3);
  camera.up.set(0, 0, 1);
  const home = new THREE.Vector3(0.49, -0.67, 0.56).normalize();
  let meshes = [];
  const ball = new THREE.Sphere();
  // Distance from which the whole part is seen.
  let far = 1;
  camera.add(lamp);
  lamp.position.set(-0.5, 1, 1);
  scene.add(camera);

  const canvas = renderer.domElement;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label",
    "The part, to be turned by dragging or with the arrow keys, nearer and farther with + and -, back with Home");
  const controls = new THREE.OrbitControls(camera, canvas);
  controls.enablePan = false;
  const draw = () => renderer.render(scene, camera);
  // Looks from a multiple of `far` along each axis.
  const look = (arm) => {
    camera.position.copy(ball.center).addScaledVector(arm, far);
    controls.update();
    draw();
  };

  // Takes the part that the page holds, and keeps the side from which the one before was seen.
  const load = () => {
    const arm = meshes.length ? camera.position.clone().sub(ball.center).divideScalar(far) : home;
    for (const mesh of meshes) {
      mesh.geometry.dispose();
      scene.remove(mesh);
    }
    const letters = atob(data.textContent.trim());
    const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    ball.radius = 0;
    meshes = triangles(bytes).map((geometry, k) => {
      geometry.computeBoundingSphere();
      ball.radius = Math.max(ball.radius, geometry.boundingSphere.radius);
      ball.center.copy(geometry.boundingSphere.center);
      return new THREE.Mesh(geometry, materials[Math.min(k, 1)]);
    });
    scene.add(...meshes);
    far = 1.05 * ball.radius / Math.sin(Math.PI * 15 / 180);
    [camera.near, camera.far] = [ball.radius / 50, ball.radius * 50];
    camera.updateProjectionMatrix();
    controls.target.copy(ball.center);
    [controls.minDistance, controls.maxDistance] = [0.3 * far, 4 * far];
    look(arm);
  };
  load();
  controls.addEventListener("change", draw);
  data.redraw = load;

  const turn = (around, up, zoom) => {
    const arm = camera.position.clone().sub(ball.center);
    const flat = Math.hypot(arm.x, arm.y);
    const azimuth = Math.atan2(arm.y, arm.x) + around;
    const limit = 0.99 * Math.PI / 2;
    const height = Math.min(limit, Math.max(-limit, Math.atan2(arm.z, flat) + up));
    const length = Math.min(4 * far, Math.max(0.3 * far, arm.length() * zoom));
    camera.position.set(Math.cos(height) * Math.cos(azimuth), Math.cos(height) * Math.sin(azimuth), Math.sin(height))
      .multiplyScalar(length).add(ball.center);
    controls.update();
    draw();
  };
  const step = Math.PI / 18;
  const keys = {
    ArrowLeft: [-step, 0, 1], ArrowRight: [step, 0, 1], ArrowUp: [0, step, 1], ArrowDown: [0, -step, 1],
    "+": [0, 0, 0.9], "=": [0, 0, 0.9], "-": [0, 0, 1 / 0.9],
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.key === "Home") {
      look(home);
    } else if (keys[event.key] && !event.ctrlKey && !event.metaKey && !event.altKey) {
      turn(...keys[event.key]);
    } else {
      return;
    }
    event.preventDefault();
  });

  const fit = () => {
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    renderer.setSize(box.clientWidth, box.clientHeight, false);
    camera.aspect = box.clientWidth / Math.max(1, box.clientHeight);
    camera.updateProjectionMatrix();
    draw();
  };
  box.append(canvas);
  new ResizeObserver(fit).observe(box);
  fit();
})();
