// viewer.js: the tree viewer of the gallery. A scene comes as a script that calls htreeScene(NAME, JSON), so that the
// page works from a file as well as from a server; htree-nodes wrote the JSON.
import { stage } from './stage.js';
import { kinds, types } from './words.js';

const $ = (id) => document.getElementById(id);
const scenes = {};
const shown = { scene: null, kind: 'h', level: 4, only: false, mesh: true, hidden: new Set(['empty']) };
let draw;

const tree = () => scenes[shown.scene].trees.find((t) => t.kind === shown.kind);
const number = (n) => n.toLocaleString('en');

// ---- Scenes ----------------------------------------------------------------------------------------

function load(name) {
    return new Promise((done, failed) => {
        if (scenes[name]) return done();
        const script = document.createElement('script');
        script.src = `trees/${name}.js`;
        script.onload = done;
        script.onerror = () => failed(new Error(`trees/${name}.js cannot be read`));
        document.head.append(script);
    });
}

window.htreeScene = (name, json) => {
    scenes[name] = json;
};

async function showScene(name) {
    await load(name);
    shown.scene = name;
    draw.mesh(scenes[name].positions);
    fillKinds();
    showKind(shown.kind);
}

// ---- Controls --------------------------------------------------------------------------------------

function fillKinds() {
    $('kind').replaceChildren(...scenes[shown.scene].trees.map((t) => new Option(kinds[t.kind].name, t.kind)));
    if (!tree()) shown.kind = scenes[shown.scene].trees[0].kind;
    $('kind').value = shown.kind;
}

function showKind(kind) {
    shown.kind = kind;
    const last = tree().levels - 1;
    $('level').max = last;
    $('level').disabled = last === 0;
    shown.level = Math.min(shown.level, last);
    $('level').value = shown.level;
    $('what').textContent = kinds[kind].text;
    draw.tree(tree().nodes);
    fillLegend();
    update();
}

function legendRow(type) {
    const row = document.createElement('button');
    row.type = 'button';
    row.dataset.type = type;
    row.title = types[type].text;
    row.style.setProperty('--colour', types[type].colour);
    row.innerHTML = '<i></i><span></span><b></b>';
    row.querySelector('span').textContent = types[type].name;
    row.onclick = () => {
        if (!shown.hidden.delete(type)) shown.hidden.add(type);
        update();
    };
    return row;
}

function fillLegend() {
    $('legend').replaceChildren(...Object.keys(tree().nodes).map(legendRow));
}

// ---- What is seen ----------------------------------------------------------------------------------

// Of each type: nodes at the levels that are shown, and at all.
function counts() {
    const inside = (level) => (shown.only ? level === shown.level : level <= shown.level);
    return Object.entries(tree().nodes).map(([type, nodes]) => ({
        type,
        seen: nodes.level.filter(inside).length,
        all: nodes.level.length,
    }));
}

function update() {
    const { levels, bytes } = tree();
    const rows = counts();
    const all = rows.reduce((sum, row) => sum + row.all, 0);
    for (const row of rows) {
        const button = $('legend').querySelector(`[data-type=${row.type}]`);
        button.setAttribute('aria-pressed', !shown.hidden.has(row.type));
        button.querySelector('b').textContent = `${number(row.seen)} of ${number(row.all)}`;
    }
    $('level-text').textContent = `${shown.level} of ${levels - 1}`;
    $('figures').textContent =
        `${number(scenes[shown.scene].triangles)} triangles, ${number(all)} nodes, ${number(Math.round(bytes / 1024))} KB`;
    $('canvas').setAttribute('aria-label',
        `${kinds[shown.kind].name} of the scene ${shown.scene}, ` + (shown.only ? 'level' : 'down to level') +
        ` ${shown.level}: ` + rows.map((row) => `${row.seen} ${types[row.type].name}`).join(', '));
    draw.show(shown);
}

function listen() {
    $('scene').onchange = (event) => showScene(event.target.value);
    $('kind').onchange = (event) => showKind(event.target.value);
    $('level').oninput = (event) => {
        shown.level = Number(event.target.value);
        update();
    };
    for (const id of ['only', 'mesh']) {
        $(id).checked = shown[id];
        $(id).onchange = (event) => {
            shown[id] = event.target.checked;
            update();
        };
    }
}

async function start() {
    try {
        if (!document.createElement('canvas').getContext('webgl2')) throw new Error('this browser has no WebGL');
        draw = stage($('canvas'), types);
        listen();
        await showScene($('scene').value);
        $('viewer').classList.add('ready');
        window.htreeViewer = { shown, draw };
    } catch (error) {
        $('sorry').textContent = `There is no tree viewer here: ${error.message}.`;
        $('viewer').classList.add('failed');
    }
}
start();
