// A person walks among the columns of a scene, which hide the person and are hidden in turn.
import * as THREE from "three";
import { PointreelObject } from "pointreel-player/three";

const canvas = document.querySelector("canvas");
const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
const scene = new THREE.Scene();
scene.background = new THREE.Color(0x20242c);
const camera = new THREE.PerspectiveCamera(40, 1, 0.1, 100);
scene.add(new THREE.HemisphereLight(0xffffff, 0x404040, 3));

const floor = new THREE.Mesh(new THREE.PlaneGeometry(6, 6), new THREE.MeshStandardMaterial({ color: 0x4a5260 }));
floor.rotation.x = -Math.PI / 2;
scene.add(floor);
for (const [x, z, color] of [[0.35, 0.8, 0xd9903d], [-0.35, -0.8, 0x3d7fd9]]) {
  const column = new THREE.Mesh(new THREE.CylinderGeometry(0.12, 0.12, 2, 32), new THREE.MeshStandardMaterial({ color }));
  column.position.set(x, 1, z);
  scene.add(column);
}

const person = new PointreelObject(renderer);
person.addEventListener("error", () => { document.querySelector("output").textContent = person.error; });
scene.add(person);
person.load("http://127.0.0.1:8090/soccer-shoot", { loop: true }).then(() => person.play(), () => {});

let angle = 0, held = false;
canvas.addEventListener("pointerdown", (event) => { held = true; canvas.setPointerCapture(event.pointerId); });
canvas.addEventListener("pointerup", () => { held = false; });
canvas.addEventListener("pointermove", (event) => { if (held) angle -= event.movementX / 200; });

renderer.setAnimationLoop(() => {
  const { clientWidth: width, clientHeight: height } = canvas;
  renderer.setSize(width, height, false);
  camera.aspect = width / height;
  camera.position.set(4 * Math.sin(angle), 1.5, 4 * Math.cos(angle));
  camera.lookAt(0, 0.85, 0);
  camera.updateProjectionMatrix();
  renderer.render(scene, camera);
});
