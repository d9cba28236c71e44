// Generated from crates/scene/src/shape.rs by `make figures`.

export type HeightField = { 
/**
 * Lengths along x and y, m.
 */
size: [number, number], 
/**
 * Number of points along y.
 */
columns: number, 
/**
 * Heights, upward, m. Rows of points along y follow each other along x.
 */
heights: Array<number>, };

export type Shape = "HalfSpace" | { "Box": { 
/**
 * Edge lengths along x, y, z.
 */
size: [number, number, number], } } | { "Cylinder": { 
/**
 * Radius.
 */
radius: number, 
/**
 * Length along z.
 */
length: number, } } | { "Ball": { 
/**
 * Radius.
 */
radius: number, } } | { "Hull": { 
/**
 * At least four points that are not in one plane.
 */
points: Array<[number, number, number]>, } } | { "Mesh": { 
/**
 * Corners.
 */
vertices: Array<[number, number, number]>, 
/**
 * Indices of three corners each.
 */
triangles: Array<[number, number, number]>, } } | { "HeightField": HeightField };
