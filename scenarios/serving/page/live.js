// The page: asks, shows, and moves while it holds the arm.
import { Refused, ask, lease, takeLease } from "./api.js";
import { faultForm, faultOf, faultText } from "./faults.js";
import { arrows, overlay, scatter } from "./plots.js";
import { Space } from "./scene.js";

const $ = id => document.getElementById(id);
const DEGREE = 180 / Math.PI;
// The reports' colours.
const TWIN = { drawing: "#56b4e9", calibrated: "#d55e00", extended: "#009e73" };
const colours = { measured: "#0072b2", twin: TWIN.drawing };
let info, state, space, effects = [], wanted = null, moving = false, opened = 0;
let misses = [];  // of the recorded poses, as they were when they were taken
let shown = null;

// Where pictures are counted none is taken unasked: the sliders move, the button takes.
const counted = () => state?.pictures_left !== null && state?.pictures_left !== undefined;

const say = text => { $("status").textContent = text; };
const warn = text => { $("banner").textContent = text; $("banner").hidden = !text; };

async function tried(action) {
  try { warn(""); return await action(); } catch (error) {
    warn(error instanceof Refused ? error.message : `the server does not answer (${error.message}); is it still running?`);
    return undefined;
  }
}

async function take() {
  await tried(async () => {
    await takeLease();
    await ask("POST", "api/connect");
    await ask("POST", "api/move", { q_cmd_rad: info.start_rad, approach: true });
    if (!counted()) await ask("POST", "api/look", {});
    await refresh();
  });
}

async function follow() {  // the sliders: the newest wish counts, those between are left out
  if (moving) return;
  moving = true;
  while (wanted) {
    const q = wanted;
    wanted = null;
    await tried(async () => {
      await ask("POST", "api/move", { q_cmd_rad: q, approach: true });
      if (!counted()) await ask("POST", "api/look", {});
    });
  }
  moving = false;
}

function setJoints(q, but) {
  document.querySelectorAll(".joint").forEach((row, joint) => row.querySelectorAll("input").forEach(input => {
    if (input !== but && document.activeElement !== input) input.value = (q[joint] * DEGREE).toFixed(1);
  }));
}

function buildJoints() {
  info.joints.forEach((joint, number) => {
    const row = document.createElement("div");
    row.className = "joint";
    const limits = { min: Math.ceil(joint.min_rad * DEGREE), max: Math.floor(joint.max_rad * DEGREE), step: 0.5 };
    const label = Object.assign(document.createElement("label"), { textContent: `joint ${number + 1}, °`, htmlFor: `joint-${number + 1}` });
    const slider = Object.assign(document.createElement("input"), { type: "range", id: `joint-${number + 1}`, ...limits });
    const text = Object.assign(document.createElement("input"), { type: "number", ...limits });
    text.setAttribute("aria-label", `joint ${number + 1}, degrees`);
    // While somebody types, what stands there is not yet what he wants: an empty field, a lone minus, a first digit.
    for (const input of [slider, text]) input.addEventListener(input === slider ? "input" : "change", () => {
      if (input.value === "") { setJoints(state.q_cmd_rad ?? info.start_rad); return; }
      input.value = Math.min(Math.max(Number(input.value), limits.min), limits.max);
      const q = [...document.querySelectorAll(".joint")].map((one, k) =>
        (k === number ? Number(input.value) : Number(one.querySelector("input[type=range]").value)) / DEGREE);
      setJoints(q, input);
      if (input === text) slider.value = input.value;
      wanted = q;
      follow();
    });
    row.append(label, slider, text);
    $("joints").append(row);
  });
}

function button(text, action) {
  const element = Object.assign(document.createElement("button"), { type: "button", textContent: text });
  element.addEventListener("click", () => tried(action));
  return element;
}

const run = body => async () => { await ask("POST", "api/plan", body); await refresh(); };

async function putFaults(faults) {
  say("the bench is rebuilt …");
  await ask("PUT", "api/faults", { faults });
  await ask("POST", "api/look", {});
  await refresh();
}

function showState() {
  const mine = state.yours, busy = Boolean(state.running);
  say(!state.connected ? "the arm is detached" : state.running ? `running ${state.running}` : state.said || (mine ? "the arm is yours" : "somebody else moves the arm; you may watch"));
  $("take").hidden = mine && state.connected;
  $("take").disabled = state.held && !mine;
  $("stop").hidden = !busy;
  $("progress").hidden = !busy;
  $("progress").value = state.progress;
  const locked = !mine || !state.connected || busy;
  document.querySelectorAll(".move input, .move .buttons button:not(#stop), .faults button, #clear").forEach(element => { element.disabled = locked; });
  const working = state.jobs.some(job => job.state === "running");
  for (const id of ["calibrate", "diagnose"]) {
    $(id).disabled = !state.poses || working || busy;
    $(id).hidden = !info.tools.includes(id);
  }
  $("left").hidden = $("hand-in").hidden = !counted();
  $("clear").hidden = counted();
  if (counted()) {
    $("left").textContent = `${state.pictures_left} pictures left; each is kept`;
    $("keep").textContent = "Take a picture here";
    $("keep").disabled ||= !state.pictures_left;
  }
  $("download").hidden = !state.poses;
  $("twin-name").textContent = state.twin;
  colours.twin = TWIN[state.twin] ?? TWIN.drawing;
  document.documentElement.style.setProperty("--twin", colours.twin);
  while ($("faults-in").children.length > state.faults.length) $("faults-in").lastChild.remove();
  state.faults.forEach((fault, number) => shownAs($("faults-in"), number, faultText(fault), () => [faultText(fault),
    button("take out", () => putFaults(state.faults.filter((_, other) => other !== number)))]));
  state.jobs.forEach(showJob);
  if (state.version !== info.version) {
    warn("the server is another version now; this page loads itself again");
    setTimeout(() => location.reload(), 3000);
  }
  if (shown) draw(shown);
}

// An item is built anew only when it looks otherwise: a button that is focused stays, and nothing is read out twice.
function shownAs(list, number, looks, build) {
  const item = list.children[number] ?? list.appendChild(document.createElement("li"));
  if (item.dataset.looks === looks) return item;
  const focused = item.contains(document.activeElement) ? document.activeElement.textContent : null;
  item.dataset.looks = looks;
  item.replaceChildren(...build());
  if (focused !== null) [...item.querySelectorAll("button")].find(one => one.textContent === focused)?.focus();
  return item;
}

function showJob(job, number) {
  const said = job.state === "done" ? job.headline : job.said, report = job.results.includes("report.html");
  const next = job.results.includes("next_experiment.csv") && state.yours;
  const item = shownAs($("jobs"), number, JSON.stringify([job.state, said, report, next]), () => {
    const seconds = document.createElement("small");
    seconds.setAttribute("aria-hidden", "true");  // it counts, and would be read out every second
    const parts = [`${job.kind}: ${said} `, seconds, " "];
    if (job.state === "running") parts.push(button("stop", () => ask("DELETE", `api/jobs/${job.number}`)));
    if (report) parts.push(button("open the report", () => openReport(job.number)));
    if (next) parts.push(button("run the next experiment", run({ job: job.number })));
    return parts;
  });
  item.dataset.state = job.state;
  item.querySelector("small").textContent = `${job.seconds.toFixed(0)} s`;
  if (report && job.number > opened) { opened = job.number; openReport(job.number); }
}

function openReport(number) {
  $("report-panel").hidden = false;
  $("report").src = `api/jobs/${number}/report.html`;
}

const NO_TOKEN = "This page needs its token: open it by the link that armtwin serve printed.";
let away = false;

function lost(error) {
  away = true;
  warn(error.status === 401 ? NO_TOKEN : "the server does not answer; is it still running?");
}

async function refresh() {
  state = await ask("GET", "api/state");
  if (away) warn("");
  away = false;
  while ($("jobs").children.length > state.jobs.length) $("jobs").lastChild.remove();  // the server was started anew
  showState();
  if (state.poses < misses.length) misses = [];
  if (state.poses > misses.length) misses.push(...await ask("GET", `api/misses?after=${misses.length}`));
  showMisses();
}

function showShot(shot) {
  $("picture").src = `api/picture.jpg?number=${shot.number}`;
  shown = shot;
  draw(shot);
  if (!moving && !wanted) setJoints(shot.q_cmd_rad);
  const names = info.marker_names.filter(name => shot.miss_mm[name]);
  $("marker-text").textContent = names.map(name => `${name.toUpperCase()} ${Math.hypot(...shot.miss_mm[name]).toFixed(2)} mm off`).join(", ");
}

function draw(shot) {
  overlay($("overlay"), shot, info, colours);
  space?.show(shot, colours.twin);
}

function showMisses() {
  const sized = misses.filter(one => one.worst_mm !== null), seen = misses.filter(one => one.miss_mm);
  const rms = Math.sqrt(sized.reduce((sum, one) => sum + one.worst_mm ** 2, 0) / Math.max(sized.length, 1));
  $("misses-text").textContent = misses.length
    ? `${misses.length} ${misses.length === 1 ? "pose" : "poses"} recorded; the twin of the time missed the worst marker by ${rms.toFixed(2)} mm RMS. A good picture's noise alone is about 0.01 mm.`
    : "Nothing is recorded yet: run a trajectory.";
  const enlarged = arrows($("arrows"), seen.map(one => ({ x: one.tip_mm[0], y: one.tip_mm[1], dx: one.miss_mm[0], dy: one.miss_mm[1], colour: TWIN[one.twin] })), colours);
  $("arrows-caption").textContent = seen.length ? `tip: from twin to measurement, drawn ${Number(enlarged.toPrecision(2))} times as long` : "";
  scatter($("order"), sized.map((_, k) => k), sized.map(one => one.worst_mm), sized.map(one => TWIN[one.twin]));
  showDirections(sized);
}

function showDirections(sized) {  // the last turn of the joint that is chosen decides the side
  const joint = Number($("turning").value), xs = [], ys = [], hues = [];
  let turn = 0;
  sized.forEach((one, k) => {
    turn = k ? Math.sign(one.q_cmd_rad[joint] - sized[k - 1].q_cmd_rad[joint]) || turn : 0;
    if (turn) { xs.push(turn + 0.3 * Math.sin(7 * k)); ys.push(one.worst_mm); hues.push(TWIN[one.twin]); }
  });
  scatter($("direction"), xs, ys, hues);
}

async function watch() {
  for (let after = 0; ;) {
    try {
      const shot = await ask("GET", `api/shot?after=${after}`);
      if (shot) { after = shot.number; showShot(shot); }
    } catch { await new Promise(done => setTimeout(done, 1000)); }
  }
}

function listen() {
  $("take").addEventListener("click", take);
  $("keep").addEventListener("click", () => tried(async () => { await ask("POST", "api/look", { keep: "by_hand" }); await refresh(); }));
  $("stop").addEventListener("click", () => tried(() => ask("DELETE", "api/plan")));
  $("clear").addEventListener("click", () => tried(async () => { await ask("POST", "api/recording"); misses = []; showMisses(); await refresh(); }));
  for (const kind of ["calibrate", "diagnose"]) $(kind).addEventListener("click", () => tried(async () => { await ask("POST", "api/jobs", { kind }); await refresh(); }));
  $("turning").addEventListener("change", showMisses);
  $("fault-name").addEventListener("change", chooseFault);
  $("fault-form").addEventListener("submit", event => {
    event.preventDefault();
    tried(() => putFaults([...state.faults, faultOf(effects[$("fault-name").selectedIndex], $("fault-form"))]));
  });
}

function chooseFault() {
  const effect = effects[$("fault-name").selectedIndex];
  $("fault-summary").textContent = effect.summary;
  faultForm(effect, $("fault-fields"), info.marker_names);
}

async function start() {
  try { info = await ask("GET", "api/bench"); } catch (error) {
    say("not connected");
    warn(error.status === 401 ? NO_TOKEN : error.message);
    return;
  }
  $("title").textContent = `· ${info.title} (${info.kind})`;
  $("truth-key").hidden = info.kind !== "simulated";
  buildJoints();
  for (const [name, poses] of Object.entries(info.plans)) $("plans").append(button(`${name.replaceAll("_", " ")} (${poses})`, run({ name })));
  $("plans").append(button("all of them", run({ name: "all" })));
  try { space = new Space($("space"), info.link_lengths_mm, info.joints.length); } catch { $("space").replaceWith("This browser draws no WebGL."); }
  effects = await ask("GET", "api/effects");
  if (effects.length) {
    $("faults-panel").hidden = false;
    effects.forEach(effect => $("fault-name").append(new Option(effect.name.replaceAll("_", " "), effect.name)));
    $("fault-name").value = "backlash";
    if ($("fault-name").selectedIndex < 0) $("fault-name").selectedIndex = 0;
    chooseFault();
  }
  info.joints.forEach((_, joint) => $("turning").append(new Option(`joint ${joint + 1}`, joint)));
  await refresh();
  if (!state.held) await take();
  listen();  // what is asked before the arm is taken would be refused without a word
  watch();
  setInterval(() => refresh().catch(lost), 1000);
}

start();
