// Generates the reader of the server's binary messages, and its types, from live.proto.

import { writeFileSync } from 'node:fs';
import { compileRaw } from 'pbf/compile';
import schema from 'resolve-protobuf-schema';

const PROTO = new URL('../crates/page-protocol/proto/live.proto', import.meta.url).pathname;
const NUMBERS = ['double', 'float', 'uint32', 'sint32'];

/** The files, by their paths in this folder. */
export function generated() {
  const proto = schema.sync(PROTO);
  const head = '// Generated from crates/page-protocol/proto/live.proto by `npm run generate`.\n';
  const types = proto.messages.map(typesOf).join('\n');
  return {
    'src/protocol/live.pb.js': head + compileRaw(proto, { noWrite: true }),
    'src/protocol/live.pb.d.ts': `${head}\nimport type { PbfReader } from 'pbf';\n\n${types}`,
  };
}

function typesOf({ name, fields }) {
  const lines = fields.map((field) => `  ${field.name}: ${typeOf(field)};\n`).join('');
  return `export interface ${name} {\n${lines}}\nexport function read${name}(pbf: PbfReader, end?: number): ${name};\n`;
}

function typeOf({ type, repeated }) {
  const single = NUMBERS.includes(type) ? 'number' : type === 'bytes' ? 'Uint8Array<ArrayBuffer>' : type;
  if (repeated) return `${single}[]`;
  // Numbers and texts that are not there are read as 0 and as empty.
  return ['number', 'string'].includes(single) ? single : `${single} | undefined`;
}

if (process.argv[1] === import.meta.filename) {
  for (const [path, text] of Object.entries(generated())) writeFileSync(new URL(path, import.meta.url), text);
}
