// Writes coastlines.json of world-atlas: closed outlines of land, hundredths of a degree, as in README.md.
import { readFileSync, writeFileSync } from "node:fs";
import { feature } from "topojson-client";

const world = JSON.parse(readFileSync("node_modules/world-atlas/land-110m.json", "utf-8"));
const polygons = feature(world, world.objects.land).features.flatMap((f) => f.geometry.coordinates);
const rings = polygons.flat();
const points = Int16Array.from(rings.flat(2), (degrees) => Math.round(100 * degrees));
const data = Buffer.from(points.buffer).toString("base64");
writeFileSync("coastlines.json", JSON.stringify({ rings: rings.map((ring) => ring.length), data }) + "\n");
