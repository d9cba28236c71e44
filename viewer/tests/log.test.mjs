// The reader and the player of logs, on logs that the real program wrote.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, openAsBlob, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { runnerImport } from 'vite';
import { connectClient, program, root, startServer, until } from './server.mjs';

const { module: logs } = await runnerImport(join(root, 'viewer/src/log/index.ts'));
const { module: lz4 } = await runnerImport(join(root, 'viewer/src/log/lz4.ts'));
const { module: mcap } = await runnerImport(join(root, 'viewer/src/log/mcap.ts'));
const { module: messages } = await runnerImport(join(root, 'viewer/src/log/messages.ts'));
const { Source } = (await runnerImport(join(root, 'viewer/src/log/source.ts'))).module;
const old = join(root, 'crates/logbook/tests/logs/before-trees.mcap');

const folder = mkdtempSync(join(tmpdir(), 'usarsim-log-'));
const MAP = `description = "A floor and two boxes"
[[half_space]]
name = "floor"
material = "carpet"
[[box]]
name = "pushed"
size = [0.2, 0.4, 0.2]
position = [0.8, 0.0, -0.1]
mass = 1.0
material = "carpet"
[[box]]
name = "alone"
size = [0.2, 0.4, 0.2]
position = [5.0, 5.0, -0.1]
mass = 1.0
material = "carpet"
[[start]]
name = "PlayerStart_0"
position = [0.0, 0.0, 0.0]
rotation = [0.0, 0.0, 0.0]
`;

/** It answers for scenes; the one that wrote the log is gone. */
let server;
let path;

before(async () => {
  const map = join(folder, 'map.toml');
  writeFileSync(map, MAP);
  const writer = await startServer('--map', map, '--rtf', '4', '--log', 'run.mcap');
  path = join(writer.folder, 'run.mcap');
  const init = (robotClass, name, place) => `INIT {ClassName USARBot.${robotClass}} {Name ${name}} {Location ${place}}`;
  const joint = 'SET {Type Joint} {Name ArmJoint1} {Opcode Angle} {Params 1}';
  const arm = await connectClient(
    writer.port,
    init('YouBotArm', 'Arm', '0,-3,-0.1'),
    'DRIVE {RotationalVelocity 0.5}',
    joint,
  );
  const pusher = await connectClient(writer.port, init('P3AT', 'Pusher', '0,0,-0.2'), 'DRIVE {Left 5} {Right 5}');
  await arm.reaches(6);
  pusher.end();
  await arm.reaches(7);
  const next = await connectClient(writer.port, init('P2DX', 'Next', '0,3,-0.2'), 'DRIVE {Left 2} {Right 1}');
  await next.reaches(9);
  await writer.stop();
  server = await startServer('--map', 'smooth');
});

after(async () => {
  await server?.stop();
  rmSync(folder, { recursive: true });
});

/** As the page asks its server. */
async function askScene(stored) {
  const response = await fetch(new URL('scene.json', server.url), { method: 'POST', body: stored });
  if (!response.ok) throw new Error(await response.text());
  return response.json();
}

const open = async (file) => logs.LogFile.open(await openAsBlob(file), askScene);
const usarsim = (...args) => execFileSync(program, ['log', ...args], { maxBuffer: 1 << 28 }).toString();

/** The rows of `usarsim log export --csv` by their columns. */
function tableOf(file) {
  const [head, ...rows] = usarsim('export', file, '--csv').trim().split('\n');
  const names = head.split(',');
  return rows.map((row) => {
    const values = row.split(',');
    return Object.fromEntries(names.map((name, at) => [name, Number(values[at] || NaN)]));
  });
}

/** A file with other bytes. */
function changed(name, change) {
  const file = join(folder, name);
  writeFileSync(file, change(readFileSync(path)));
  return file;
}

/** Compares every robot of a frame with the rows of its time. */
function assertSame(frame, rows) {
  assert.deepEqual(
    frame.robots.map(({ id }) => id),
    rows.map(({ robot }) => robot),
  );
  frame.robots.forEach((robot, at) => {
    const row = rows[at];
    assert.deepEqual(robot.pose, [row.x, row.y, row.z, row.qx, row.qy, row.qz, row.qw]);
    const wheels = robot.wheels.flatMap(({ angle, speed }) => [angle, speed]);
    const recorded = robot.wheels.flatMap((_, at) => [row[`wheel_angle_${at + 1}`], row[`wheel_speed_${at + 1}`]]);
    assert.deepEqual(wheels, recorded);
    const size = ([x, y, z]) => Math.hypot(x, y, z);
    assert.ok(Math.abs(size(robot.linear) - size([row.vx, row.vy, row.vz])) < 1e-12);
    assert.ok(Math.abs(size(robot.angular) - size([row.wx, row.wy, row.wz])) < 1e-12);
  });
}

test('a message that is cut off is refused and a whole one is read', () => {
  // A line: connection 300, robot 1, text "abc", and a field of the future.
  const line = [8, 0xac, 2, 16, 1, 26, 3, 97, 98, 99, 0x7d, 1, 2, 3, 4];
  const read = (bytes) => messages.readLine(Uint8Array.from(bytes));
  assert.deepEqual(read(line), { connection: 300, robot: 1, line: 'abc' });
  for (const [bytes, reason] of [
    [line.slice(0, 1), /more than 10 bytes|too short/],
    [line.slice(0, 2), /more than 10 bytes|too short/],
    [line.slice(0, 9), /too short/],
    [line.slice(0, 13), /too short/],
    [[26, 0xff, 0xff, 0xff, 0xff, 15, 97], /too short/],
    [[0x3f, 0], /Unimplemented type/],
  ]) {
    assert.throws(() => read(bytes), reason, `${bytes}`);
  }
  // A packed field that claims more numbers than there are.
  assert.throws(() => messages.readRanges(Uint8Array.of(50, 0xff, 0xff, 3, 0, 0)), /too short/);
  assert.deepEqual(messages.readRanges(Uint8Array.of(50, 8, 0, 0, 0, 0, 0, 0, 0xf0, 63)), [1]);
});

test('a frame is what the program says of its time', async () => {
  const log = await open(path);
  const rows = tableOf(path);
  const times = [...new Set(rows.map(({ time }) => time))];
  assert.ok(times.length > 300, `${times.length} times`);
  const worst = { ms: 0 };
  // A robot may leave right after its last row, before the time that is asked for.
  const left = rows.findLast(({ robot }) => robot === 1).time;
  const asked = times.filter((time, at) => at % 7 === 0 && time !== left);
  for (const time of asked.toSorted(() => Math.random() - 0.5)) {
    const begin = performance.now();
    assertSame(
      await log.frameAt(time + 0.0015),
      rows.filter((row) => row.time === time),
    );
    worst.ms = Math.max(worst.ms, performance.now() - begin);
  }
  console.log(`# slowest frame after ${worst.ms.toFixed(1)} ms`);
  assert.equal(log.damage, null);
  assert.deepEqual([log.scene.seed, log.scene.time_step, log.scene.map.name], [0, 0.002, log.run.map]);
  assert.ok(Math.abs(log.end - times.at(-1)) < 0.1 && log.start === 0, `${log.end}`);
});

test('robots come and leave, and a slot is not a robot', async () => {
  const log = await open(path);
  const rows = tableOf(path);
  assert.deepEqual((await log.momentAt(0)).robots, []);
  const there = async (time) =>
    (await log.momentAt(time)).robots.map(({ name, connection }) => `${name} ${connection}`);
  const left = rows.findLast(({ robot }) => robot === 1).time;
  const came = rows.find(({ robot }) => robot === 2).time;
  assert.deepEqual(await there(left - 0.5), ['Arm 1', 'Pusher 2']);
  assert.deepEqual(await there((left + came) / 2), ['Arm 1']);
  assert.deepEqual(await there(log.end), ['Arm 1', 'Next 3']);
});

test('joints and links of an arm move', async () => {
  const log = await open(path);
  const { joints, links } = log.scene.classes.YouBotArm;
  const at = joints.findIndex(({ name }) => name === 'ArmJoint1');
  const [first, last] = [await log.frameAt(0.5), await log.frameAt(log.end)].map(({ robots }) => robots[0]);
  assert.equal(last.joints.length, joints.length);
  assert.equal(last.links.length, links.length);
  assert.ok(Math.abs(last.joints[at].position - 1) < 0.02, `${last.joints[at].position}`);
  assert.ok(last.joints[at].position > first.joints[at].position);
  assert.notDeepEqual(last.links[at], first.links[at]);
  assert.equal(last.wheels[0].rollers.length, 6);
  // It turns on the spot, clockwise. From roller to roller the rate is 0.44 to 0.50 rad/s, so the mean counts.
  const times = Array.from({ length: 80 }, (_, at) => log.end - at * 0.05);
  const moving = await Promise.all(times.map(async (time) => (await log.frameAt(time)).robots[0]));
  const mean = (values) => values.reduce((sum, value) => sum + value) / values.length;
  const [rate, speed] = [mean(moving.map((it) => it.angular[2])), mean(moving.map((it) => it.linear[0]))];
  assert.ok(Math.abs(rate - 0.48) < 0.02 && Math.abs(speed) < 0.02, `${rate} ${speed}`);
});

test('an object that was pushed stays where it is, however long ago', async () => {
  const log = await open(path);
  const [first, last] = [await log.frameAt(0.2), await log.frameAt(log.end)].map(({ objects }) => objects);
  assert.deepEqual(
    [first, last].map((objects) => objects.map(({ number }) => number)),
    [
      [0, 1],
      [0, 1],
    ],
  );
  const x = (objects) => objects.map(({ pose }) => pose[0]);
  assert.ok(Math.abs(x(first)[0] - 0.8) < 0.01 && x(last)[0] > 1, `${x(first)} ${x(last)}`);
  assert.ok(Math.abs(x(last)[1] - 5) < 0.01, `${x(last)}`);
});

test('lines are those of the wire', async () => {
  const log = await open(path);
  const lines = await log.linesBetween(1, 2);
  const wire = lines.map(({ time, direction, connection, text }) => {
    return `${time.toFixed(4)} ${connection} ${direction === 'in' ? '<' : '>'} ${text}`;
  });
  const cat = usarsim('cat', path, '--from', '1', '--to', '2').trimEnd().split('\n');
  assert.deepEqual(wire.slice(-50), cat.slice(-50));
});

test('scans are those of lasers and sonars', async () => {
  const log = await open(path);
  const scans = await log.scansBetween(log.end - 0.5, log.end);
  const of = (robot, robotClass) => {
    const { sensors } = log.scene.classes[robotClass];
    return scans.filter((scan) => scan.robot === robot).map((scan) => ({ ...scan, ...sensors[scan.sensor] }));
  };
  const [laser] = of(0, 'YouBotArm').filter(({ fan }) => fan?.level);
  assert.ok(laser.ranges.length > 100 && laser.ranges.every((part) => part >= 0 && part <= 1));
  const sonars = of(2, 'P2DX').filter(({ fan, ranges }) => !fan && ranges.length === 1);
  assert.equal(sonars.length, log.scene.classes.P2DX.sensors.filter(({ max_range, fan }) => max_range && !fan).length);
  assert.ok(sonars.length > 1, `${sonars.length} sonars`);
  // The newest line of the wire has the same, truncated to four decimals.
  const { name, max_range, ranges } = sonars[0];
  const line = usarsim('cat', path, '--robot', '2', '--type', 'Sonar').trimEnd().split('\n').at(-1);
  const [, range] = new RegExp(`{Name ${name}(?:} {| )Range ([^}]*)}`).exec(line);
  assert.ok(Math.abs(ranges[0] * max_range - Math.min(Number(range), max_range)) < 1.1e-4, line);
});

test('it plays, pauses, jumps and ends', async () => {
  const log = await open(path);
  const seen = { frames: [], status: [], scans: 0, lines: [], readings: {}, jumps: 0, ended: 0, failed: [] };
  const player = new logs.Player(log, {
    frame: ({ time }) => seen.frames.push(time),
    status: (robots) => seen.status.push(robots.map(({ name }) => name).join()),
    scan: ({ ranges }) => (seen.scans += ranges.length > 100 && ranges.every((it) => it >= 0 && it <= 1)),
    line: ({ time, text }) => seen.lines.push([time, text]),
    reading: ({ type, quantities }) => (seen.readings[type] = quantities.map(({ name }) => name).join()),
    jumped: () => (seen.jumps += 1),
    ended: () => (seen.ended += 1),
    failed: (reason) => seen.failed.push(reason),
  });
  player.wantLines = true;
  await player.seek(0.5);
  const begin = performance.now();
  player.play(1);
  await until(() => seen.frames.length >= 10);
  player.pause();
  const paused = player.time;
  const passed = (performance.now() - begin) / 1000;
  assert.ok(paused > 0.6 && paused < 0.5 + passed + 0.05, `${paused} after ${passed} s`);
  assert.ok(seen.frames.every((time, at) => time >= (seen.frames[at - 1] ?? 0)));
  // Each line once.
  const cat = usarsim('cat', path, '--to', String(seen.frames.at(-1)))
    .trimEnd()
    .split('\n');
  // Meanwhile whatever would have moved it became due.
  await new Promise(setImmediate);
  assert.equal(player.time, paused);
  assert.equal(seen.lines.length, cat.length);
  assert.equal(seen.jumps, 1);
  assert.ok(seen.scans > 0, `${seen.scans} scans`);
  assert.equal(seen.readings.GroundTruth, 'position,angles');
  await player.step(0.02);
  assert.ok(Math.abs(player.time - paused - 0.02) < 1e-9 && seen.jumps === 1);
  await player.step(-0.5);
  assert.equal(seen.jumps, 2);
  // Of many that come at once few are read.
  const count = seen.frames.length;
  await Promise.all(Array.from({ length: 100 }, (_, at) => player.seek(at / 50)));
  assert.ok(seen.frames.length - count <= 3 && seen.frames.at(-1) === 1.98, `${seen.frames.slice(count)}`);
  await player.seek(1e9);
  assert.equal(player.time, log.end);
  await player.seek(log.end - 0.2);
  player.play(5);
  await until(() => !player.isPlaying);
  assert.deepEqual([seen.ended, player.time, seen.failed], [1, log.end, []]);
  assert.equal(seen.status.at(-1), 'Arm,Next');
  const before = seen.frames.length;
  const sought = player.seek(1);
  player.close();
  await sought;
  assert.equal(seen.frames.length, before);
});

test('a log that was cut off plays up to there', async () => {
  const whole = await open(path);
  const rows = tableOf(path);
  // The scene is before the first chunk, and without it nothing can be shown.
  const [{ offset: first }] = (await mcap.readContents(new Source(await openAsBlob(path)))).chunks;
  for (const part of [0.5, 0.77, 0.9999]) {
    const at = (bytes) => first + (bytes.length - first) * part;
    const cut = await open(changed('cut.mcap', (bytes) => bytes.subarray(0, at(bytes))));
    assert.match(cut.damage, /cut off|index/);
    assert.ok(cut.end > 1 && cut.end <= whole.end, `${cut.end}`);
    assertSame(
      await cut.frameAt(0.601),
      rows.filter((row) => row.time === 0.6),
    );
    // Of the last states some may be cut off.
    for (const time of [cut.end / 2, cut.end - 0.05]) {
      assert.deepEqual(await cut.momentAt(time), await whole.momentAt(time));
    }
  }
});

test('damage is said by name', async () => {
  const { chunks } = await mcap.readContents(new Source(await openAsBlob(path)));
  const { offset, length } = chunks[Math.floor(chunks.length / 2)];
  const log = await open(changed('damaged.mcap', (bytes) => bytes.fill(0, offset + (length >> 1), offset + length)));
  const failed = [];
  const ignore = () => {};
  const listener = {
    frame: ignore,
    status: ignore,
    scan: ignore,
    line: ignore,
    reading: ignore,
    jumped: ignore,
    ended: ignore,
  };
  const player = new logs.Player(log, { ...listener, failed: (reason) => failed.push(reason) });
  player.play(10);
  await until(() => !player.isPlaying);
  assert.match(failed.join(), /^the log is damaged at byte \d+: /);
  // The rest can be looked at.
  await player.seek(log.end);
  assert.equal(failed.length, 1);
});

test('a file that is no log is refused by name', async () => {
  const refused = async (bytes, reason) => assert.rejects(logs.LogFile.open(new Blob([bytes]), askScene), reason);
  await refused('', /not an MCAP file/);
  await refused('hello, this is no log', /not an MCAP file/);
  const magic = readFileSync(path).subarray(0, 8);
  await refused(magic, /expected the metadata `run`/);
  await refused(Buffer.concat([magic, Buffer.alloc(100, 255)]), /expected the metadata `run`/);
  const newer = (bytes) =>
    Buffer.from(bytes.toString('latin1').replace('format\x01\0\0\x003', 'format\x01\0\0\x004'), 'latin1');
  await assert.rejects(open(changed('newer.mcap', newer)), /of format 4, expected 1 to 3/);
  const broken = (bytes) => Buffer.from(bytes.toString('latin1').replace('"gravity":', '"gravitY":'), 'latin1');
  await assert.rejects(open(changed('broken.mcap', broken)), /missing field `gravity`/);
});

test('an old log is played', async () => {
  const log = await open(old);
  const rows = tableOf(old);
  for (const time of [1, 1.3, 1.5])
    assertSame(
      await log.frameAt(time + 0.001),
      rows.filter((row) => row.time === time),
    );
  const robot = (await log.momentAt(1)).robots[1];
  assert.deepEqual([robot.class, robot.connection], ['KUKA_YouBot', 1]);
  // Casters are where the class has them, not at the body's middle.
  const [caster] = (await log.frameAt(1)).robots;
  assert.ok(
    caster.links.every(([x, y, z]) => Math.hypot(x, y, z) > 0.05),
    JSON.stringify(caster.links),
  );
  assert.deepEqual((await log.momentAt(log.end)).robots, []);
});

test('LZ4: matches that overlap, plain blocks, and bytes that are no frame', () => {
  const frame = (...blocks) => {
    const size = (length) => [length & 255, (length >> 8) & 255, (length >> 16) & 255, (length >>> 24) & 255];
    const head = [0x04, 0x22, 0x4d, 0x18, 0x60, 0x40, 0x82];
    const parts = blocks.flatMap(({ plain, bytes }) => [
      ...size((bytes.length | (plain ? 1 << 31 : 0)) >>> 0),
      ...bytes,
    ]);
    return Uint8Array.from([...head, ...parts, 0, 0, 0, 0]);
  };
  const text = (bytes) => Buffer.from(bytes).toString();
  // "ab", then 4 + 15 + 2 bytes from 2 back, then "!".
  const packed = { bytes: [0x2f, 97, 98, 2, 0, 2, 0x10, 33] };
  assert.equal(text(lz4.readLz4Frame(frame(packed), 24)), `${'ab'.repeat(11)}a!`);
  const plain = { plain: true, bytes: [97, 98, 99] };
  // A block may refer to the one before.
  const linked = { bytes: [0x00, 3, 0, 0x10, 33] };
  assert.equal(text(lz4.readLz4Frame(frame(plain, linked), 8)), 'abcabca!');
  for (const [bytes, size, reason] of [
    [Uint8Array.of(1, 2, 3, 4, 5), 1, /no frame/],
    [frame(packed), 23, /out of range|too long/],
    [frame(packed), 25, /24 bytes: expected 25/],
    [frame(plain), 2, /more than 2 bytes/],
    [frame({ bytes: [0x10, 97, 9, 0, 0] }), 100, /out of range/],
    [frame({ bytes: [0x10, 97, 0, 0, 0] }), 100, /out of range/],
    [frame({ bytes: [0xf0, 255, 255] }), 100, /too long/],
    [frame(packed).subarray(0, 14), 24, /too short/],
  ]) {
    assert.throws(() => lz4.readLz4Frame(bytes, size), reason);
  }
});
