// What the three-dimensional view takes of OGL; README.md says how the bundle is made of it.
export { Camera, Cylinder, Geometry, Mesh, Program, Quat, Renderer, Sphere, Texture, Transform, Vec3 } from "ogl";
