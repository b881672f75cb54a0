// The arm in space: twin and, of a simulation, the truth. Placements come in mm in the robot frame.
import { AmbientLight, BoxGeometry, Color, CylinderGeometry, DirectionalLight, GridHelper, Group, Matrix4, Mesh, MeshLambertMaterial, OrbitControls, PerspectiveCamera, Scene, WebGLRenderer } from "./three.min.js";

const WIDTH_MM = 18, THICK_MM = 8, TRUTH_BEHIND_MM = -14, KEY_TURN_RAD = 0.1;

export class Space {
  constructor(canvas, lengths, nJoints) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.scene = new Scene();
    this.scene.background = new Color("#f4f4f4");
    this.scene.add(new AmbientLight("#ffffff", 1.6));
    const sun = new DirectionalLight("#ffffff", 1.8);
    sun.position.set(200, 400, 600);
    this.scene.add(sun);
    const reach = lengths.reduce((sum, length) => sum + Math.abs(length), 0);
    const grid = new GridHelper(3 * reach, 24, "#bbb", "#ddd");
    grid.rotation.x = Math.PI / 2;
    grid.position.z = -40;
    this.scene.add(grid);
    this.camera = new PerspectiveCamera(40, 4 / 3, 1, 20 * reach);
    this.camera.position.set(0.5 * reach, 0.6 * reach, 2.4 * reach);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    canvas.addEventListener("keydown", event => this.turned(event));
    this.lengths = lengths;
    this.nJoints = nJoints;
    this.truth = this.arm("#444444", 1, TRUTH_BEHIND_MM);
    this.twin = this.arm("#56b4e9", 0.75, 0);
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  turned(event) {  // by the arrow keys, as by dragging
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!by) return;
    event.preventDefault();
    const from = this.camera.position, aside = this.camera.up.clone().cross(from).normalize();
    from.applyAxisAngle(this.camera.up, by[0] * KEY_TURN_RAD);
    from.applyAxisAngle(aside, by[1] * KEY_TURN_RAD);
    this.controls.update();
    this.draw();
  }

  arm(colour, opacity, z) {
    const group = new Group(), links = [];
    const material = new MeshLambertMaterial({ color: colour, transparent: opacity < 1, opacity });
    for (let joint = 0; joint < this.nJoints; joint++) {
      const link = new Group(), length = Math.max(Math.abs(this.lengths[joint]), 1);
      const bar = new Mesh(new BoxGeometry(length, WIDTH_MM, THICK_MM), material);
      bar.position.x = length / 2;
      const axis = new Mesh(new CylinderGeometry(WIDTH_MM * 0.7, WIDTH_MM * 0.7, THICK_MM * 1.6, 24), material);
      axis.rotation.x = Math.PI / 2;
      link.add(bar, axis);
      link.matrixAutoUpdate = false;
      link.visible = false;
      links.push(link);
      group.add(link);
    }
    group.position.z = z;
    this.scene.add(group);
    return { group, links, material };
  }

  show(shot, twinColour) {
    this.twin.material.color.set(twinColour);
    for (const [arm, bodies] of [[this.twin, shot.twin_bodies], [this.truth, shot.true_bodies]]) {
      arm.links.forEach((link, joint) => {
        const placed = bodies[`link${joint + 1}`];
        link.visible = Boolean(placed);
        if (placed) link.matrix.copy(new Matrix4().set(...placed.flat()));
      });
    }
    this.draw();
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
  }
}
