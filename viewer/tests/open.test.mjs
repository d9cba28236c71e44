// Files of other programs that are dropped on the page.

import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { X, Y, pageTest } from './pagetest.mjs';
import { number, openPage, waitForNumber } from './server.mjs';

const rough = { serve: ['--map', 'rough'] };
const card = (text) => `#opened:has-text("${text}")`;

/** A cart of two wheels and a block of wood on top that is a mesh of its package. */
const wheel = (side, y) => `
  <link name="${side}">
    <inertial><mass value="1"/><inertia ixx="0.002" iyy="0.003" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.1" length="0.05"/></geometry></collision>
  </link>
  <joint name="${side}_wheel" type="continuous">
    <parent link="base"/><child link="${side}"/><origin xyz="0 ${y} 0"/><axis xyz="0 1 0"/>
  </joint>`;
const CART = `<robot name="handcart">
  <link name="base">
    <inertial><mass value="8"/><inertia ixx="0.2" iyy="0.3" izz="0.4" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="package://handcart_description/meshes/block.stl"/></geometry></visual>
    <collision><geometry><box size="0.6 0.3 0.1"/></geometry></collision>
  </link>${wheel('left', 0.2)}${wheel('right', -0.2)}
</robot>`;
const BLOCK = `solid block
facet normal 0 0 1
outer loop
vertex -0.3 -0.15 0.1
vertex 0.3 -0.15 0.1
vertex 0 0.15 0.3
endloop
endfacet
endsolid block
`;
const COURT = `<sdf version="1.9"><world name="court">
  <include><uri>model://sun</uri></include>
  <model name="ground"><static>true</static><link name="l"><collision name="c"><geometry><plane/></geometry></collision></link></model>
  <model name="post"><static>true</static><pose>3 1 0.5 0 0 0</pose><link name="l">
    <collision name="c"><geometry><box><size>0.2 0.2 1</size></box></geometry></collision></link></model>
</world></sdf>`;

/** Writes files into a new folder, and returns its path. */
function folderOf(files) {
  const folder = mkdtempSync(join(tmpdir(), 'usarsim-drop-'));
  for (const [path, content] of Object.entries(files)) {
    mkdirSync(dirname(join(folder, path)), { recursive: true });
    writeFileSync(join(folder, path), content);
  }
  return folder;
}

/** Drops files or folders on the view, as a person does from a file manager. */
async function drop(page, paths, x = 640, y = 500) {
  const browser = await page.context().newCDPSession(page);
  const data = { items: [], files: paths, dragOperationsMask: 1 };
  for (const type of ['dragEnter', 'dragOver', 'drop'])
    await browser.send('Input.dispatchDragEvent', { type, x, y, data });
}

pageTest('a URDF that is dropped stands there with its guesses, and drives', rough, async ({ page }) => {
  const folder = folderOf({ 'cart.urdf': CART });
  await drop(page, [join(folder, 'cart.urdf')]);
  await page.waitForSelector(card('handcart: skid, 10.0 kg, 2 driven wheels'));
  await page.waitForSelector(card('steered by the sides of its wheels'));
  await page.waitForSelector(card('package `handcart_description` is not here'));
  await page.waitForSelector('[data-robot]:has-text("Robot1")');
  const x = await waitForNumber(page, X, Number.isFinite);
  await page.keyboard.down('w');
  await waitForNumber(page, X, (now) => Math.abs(now - x) > 0.2);
  await page.keyboard.up('w');
  // Dropped again, after a change, it is another class.
  writeFileSync(join(folder, 'cart.urdf'), CART.replace('value="8"', 'value="9"'));
  await drop(page, [join(folder, 'cart.urdf')], 500, 450);
  await page.waitForSelector('#opened h2:text-is("handcart_2")');
  await page.waitForSelector('[data-robot]:has-text("Robot2")');
});

pageTest('a folder that is dropped has its meshes, and asks which robot is meant', rough, async ({ page, server }) => {
  const folder = folderOf({
    'handcart_description/package.xml': '<package><name>handcart_description</name></package>',
    'handcart_description/urdf/cart.urdf': CART,
    'handcart_description/urdf/other.urdf': CART.replace('handcart"', 'other"'),
    'handcart_description/meshes/block.stl': BLOCK,
  });
  await drop(page, [join(folder, 'handcart_description')]);
  await page.click('[data-file="handcart_description/urdf/cart.urdf"]');
  await page.waitForSelector(card('handcart: skid'));
  assert.equal((await page.textContent('#opened')).includes('not here'), false);
  await page.waitForSelector('[data-robot]');
  // Pages that open later know the class, and show the robot.
  const { page: other, errors } = await openPage(page.context().browser(), server.url);
  await other.waitForSelector('[data-robot]:has-text("Robot1")');
  await other.waitForSelector('select[name=class] option[value=handcart]', { state: 'attached' });
  await other.context().close();
  assert.deepEqual(errors, []);
});

pageTest('a world that is dropped becomes the map, and robots of this page stay', rough, async ({ page }) => {
  const folder = folderOf({ 'court.world': COURT, 'cart.urdf': CART });
  await drop(page, [join(folder, 'cart.urdf')]);
  // Before, it may be somebody else's, who would have to agree.
  await page.waitForSelector('[data-robot]:has-text("yours")');
  await drop(page, [join(folder, 'court.world')]);
  await page.waitForSelector(card('court: 2 solids'));
  await page.waitForSelector('#map:text-is("court")');
  await page.waitForSelector('[data-robot]:has-text("Robot1")');
  await waitForNumber(page, Y, Number.isFinite);
  await page.click('#map');
  await page.click('[data-map=rough]');
  await page.waitForSelector('#map:text-is("rough")');
});

const refused = { ...rough, mayFail: true };
pageTest('a file that cannot be opened says why, and so does a page that may not', refused, async ({ page }) => {
  const folder = folderOf({ 'broken.urdf': '<robot name="b"><link name="a"/>', 'part.stl': BLOCK, 'note.txt': 'x' });
  await drop(page, [join(folder, 'broken.urdf')]);
  await page.waitForSelector(card('broken.urdf is not opened'));
  await page.waitForSelector('#opened .problem:has-text("broken.urdf:1:")');
  await drop(page, [join(folder, 'note.txt')]);
  await page.waitForSelector(card('nothing here can be opened'));
  await drop(page, [join(folder, 'part.stl')]);
  await page.waitForSelector('#map:text-is("part")');
  assert.ok((await number(page, '#time')) >= 0);
});

const nobody = { serve: ['--map', 'rough', '--control', 'nobody'] };
pageTest('a page that may not control the world brings nothing into it', nobody, async ({ page }) => {
  const folder = folderOf({ 'cart.urdf': CART });
  await drop(page, [join(folder, 'cart.urdf')]);
  await page.waitForSelector('#toasts:has-text("Not opened: no page controls this world")');
});
