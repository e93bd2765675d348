// SPDX-License-Identifier: MIT
// Checks GLB files with the Khronos validator: npm package gltf-validator, pinned to 2.0.0-dev.3.10.
//
//   node tools/validate_glb.mjs [--modules DIR] [--warnings] FILE...
//
// The package is found in DIR/node_modules, else along NODE_PATH. Prints a line per finding and per file;
// exits 1 if a file has errors (or, with --warnings, warnings), 2 on wrong usage or without the package.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';

const version = '2.0.0-dev.3.10';
const args = process.argv.slice(2);
const take = (name, values) => {
  const at = args.indexOf(name);
  return at < 0 ? [] : args.splice(at, values + 1).slice(1);
};
const [modules] = take('--modules', 1);
const severities = ['error', 'warning'];
const worst = args.includes('--warnings') ? 1 : 0;
const files = args.filter((arg) => arg !== '--warnings');

let validator;
try {
  const require = createRequire(modules ? join(resolve(modules), 'package.json') : import.meta.url);
  validator = require('gltf-validator');
} catch {
  console.error(`validate_glb: no gltf-validator: npm install gltf-validator@${version}`);
  process.exit(2);
}
if (files.length === 0) {
  console.error('validate_glb: no file given');
  process.exit(2);
}

let failed = false;
for (const file of files) {
  // A texture of a character that was no glTF stays where it was: that it cannot be opened here is no error.
  const options = { maxIssues: 100, ignoredIssues: ['IO_ERROR'] };
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), options);
  for (const { code, severity, message, pointer } of report.issues.messages) {
    if (severity < severities.length) console.log(`${file}: ${severities[severity]}: ${pointer ?? ''}: ${code}: ${message}`);
  }
  const { numErrors, numWarnings } = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings`);
  failed ||= numErrors > 0 || (worst === 1 && numWarnings > 0);
}
process.exit(failed ? 1 : 0);
