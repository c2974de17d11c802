// SPDX-License-Identifier: Apache-2.0
// The 3D view: the skeleton of who is seen and, once measured, their dressed body, which follows it. Metres, +y up,
// floor at y = 0, the camera that measures in the direction of +z.
'use strict';

class Stage {
  // Throws where the browser has no WebGL.
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true});
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.gammaOutput = true;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.1, 30);
    this.camera.position.set(0.9, 1.25, 3.9);
    this.orbit = new THREE.OrbitControls(this.camera, canvas);
    this.orbit.target.set(0, 0.92, 0);
    this.orbit.minDistance = 1;
    this.orbit.maxDistance = 8;
    this.orbit.addEventListener('change', () => this.requestDraw());
    this.orbit.update();
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 0.6));
    const sun = new THREE.DirectionalLight(0xffffff, 0.7);
    sun.position.set(1.5, 3, 2.5);
    this.scene.add(sun);
    const grid = new THREE.GridHelper(4, 16, 0x8a8f98, 0x8a8f98);
    grid.material.transparent = true;
    grid.material.opacity = 0.35;
    this.scene.add(grid);
    this.lines = null;
    this.avatar = null;
    this.cloth = null;  // of the avatar, where it moves
    this.avatarsRequested = 0;
    this.nodes = [];
    this.wanted = null;
    this.drawRequested = false;
    this.still = window.matchMedia('(prefers-reduced-motion: reduce)');
    new ResizeObserver(() => this.requestDraw()).observe(canvas);
    this.requestDraw();
  }

  // `bones`: [from, to, whose colour] of the joints' numbers.
  setBones(bones, jointNames) {
    if (this.lines) this.scene.remove(this.lines);
    this.bones = bones;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(bones.length * 6), 3));
    const colours = new Float32Array(bones.length * 6);
    bones.forEach(([, , like], i) => {
      const name = jointNames[like];
      const of = {L: 0xe8842c, R: 0x9a5fd0}[name[0]] || 0x3aa0c8;  // as in the camera's picture
      const colour = new THREE.Color(of);
      for (const end of [0, 1]) colour.toArray(colours, i * 6 + end * 3);
    });
    geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
    // Seen through the body.
    const material = new THREE.LineBasicMaterial({vertexColors: THREE.VertexColors, depthTest: false,
                                                  transparent: true});
    this.lines = new THREE.LineSegments(geometry, material);
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 1;
    this.lines.visible = false;
    this.scene.add(this.lines);
  }

  setJoints(joints) {
    if (!this.lines) return;
    this.lines.visible = Boolean(joints);
    if (joints) {
      const position = this.lines.geometry.attributes.position;
      this.bones.forEach(([from, to], i) => {
        position.setXYZ(2 * i, ...joints[from]);
        position.setXYZ(2 * i + 1, ...joints[to]);
      });
      position.needsUpdate = true;
    }
    this.requestDraw();
  }

  // Resolves to whether it is on the stage: not when another was requested, or none, meanwhile.
  loadAvatar(url, segments) {
    const request = ++this.avatarsRequested;
    return new Promise((resolve, reject) => new THREE.GLTFLoader().load(url, (gltf) => {
      if (request !== this.avatarsRequested) {
        resolve(false);
        return;
      }
      this.removeAvatar();
      this.avatar = gltf.scene;
      this.avatar.traverse((o) => { o.frustumCulled = false; });  // bones move it out of the box it was made in
      this.nodes = segments.map((name) => this.avatar.getObjectByName(name));
      this.cloth = new MovingCloth(this.avatar);
      this.scene.add(this.avatar);
      this.requestDraw();
      resolve(true);
    }, undefined, reject));
  }

  removeAvatar() {
    ++this.avatarsRequested;
    if (!this.avatar) return;
    this.scene.remove(this.avatar);
    this.avatar.traverse((o) => {
      if (o.geometry) o.geometry.dispose();
      if (o.material && o.material.map) o.material.map.dispose();
      if (o.material) o.material.dispose();
    });
    this.avatar = null;
    this.cloth = null;
    this.nodes = [];
    this.wanted = null;
    this.requestDraw();
  }

  // `root` and the rotation of each segment relative to its parent, as the .glb's nodes have them.
  pose(root, rotations) {
    if (!this.avatar) return;
    this.wanted = {root: new THREE.Vector3(...root), rotations: rotations.map((q) => new THREE.Quaternion(...q))};
    this.requestDraw();
  }

  requestDraw() {
    if (this.drawRequested) return;
    this.drawRequested = true;
    requestAnimationFrame(() => { this.drawRequested = false; this.draw(); });
  }

  // Frames come thirty times a second at most; in between the body glides.
  glide() {
    if (!this.wanted) return;
    const share = this.still.matches ? 1 : 0.35;
    this.nodes[0].position.lerp(this.wanted.root, share);
    let left = this.nodes[0].position.distanceTo(this.wanted.root);
    this.wanted.rotations.forEach((q, i) => {
      this.nodes[i].quaternion.slerp(q, share);
      left = Math.max(left, 1 - Math.abs(this.nodes[i].quaternion.dot(q)));
    });
    if (left > 1e-5) this.requestDraw();
  }

  draw() {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (!width || !height) return;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x !== width || size.y !== height) {
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
    }
    this.glide();
    if (this.cloth && this.cloth.advance(performance.now(), this.still.matches)) this.requestDraw();
    this.renderer.render(this.scene, this.camera);
  }
}
