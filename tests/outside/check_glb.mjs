// Asks glTF-Validator (Khronos Group) about GLB files: no error, no warning.
//
// usage: node check_glb.mjs FOLDER FILE...    FOLDER is where npm has installed gltf-validator
// Prints one line per file; exits 1 if any of them is not as it should be.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const [folder, ...files] = process.argv.slice(2);
if (files.length === 0) {
    console.error("usage: node check_glb.mjs FOLDER FILE...");
    process.exit(2);
}
const validator = createRequire(resolve(folder, "package.json"))("gltf-validator");
for (const file of files) {
    const options = { format: "glb", maxIssues: 0 };
    const { issues, info } = await validator.validateBytes(new Uint8Array(readFileSync(file)), options);
    const good = issues.numErrors === 0 && issues.numWarnings === 0 && !issues.truncated;
    const said = issues.messages.map(({ code, pointer }) => `; ${code} at ${pointer}`).join("");
    const counts = `${info.totalTriangleCount} facets, ${issues.numErrors} errors, ${issues.numWarnings} warnings`;
    console.log(`gltf-validator: ${file}: ${good ? "ok" : "FAILED"}, ${counts}${said}`);
    if (!good) process.exitCode = 1;
}
