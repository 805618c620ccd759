// The shaders that draw the cradle in space. Each thing is a rectangle, within which a shader follows a ray from the
// eye to the thing and, from polished steel, to what it mirrors. Each kind of thing has its own program: a renderer
// without a GPU computes all branches of a program for each pixel.

const COMMON = `#version 300 es
precision highp float;
layout(std140) uniform Space {
  vec4 right, up, towards; // the eye's axes
  vec4 eye;
  vec4 lens;               // focal length, where the origin is; lengths in the picture are in CSS pixels
  vec4 frame;              // how far the bars are from the middle: x, z; how high the base is, and the bars
  vec4 base;               // how far it reaches beyond the bars, how thick it is
  vec4 zenith, horizon, lamp, window, table, top, side, string_, glowing;
  vec4 size;               // of the picture, and how many of its own pixels a CSS pixel has
};
uniform vec4 thing_[5];
#define A thing_[0]        // its centre or one end, and its radius
#define B thing_[1]        // the other end; 1 for what is within a rectangle of the picture
#define C thing_[2]        // what each kind says
#define D thing_[3]
#define E thing_[4]
`;

export const VERTEX = `${COMMON}
vec3 seen(vec3 p) { // where in the picture, and how many pixels a radius is there
  p -= eye.xyz;
  float unit = -lens.x / dot(p, towards.xyz);
  return vec3(lens.yz + unit * vec2(dot(p, right.xyz), dot(p, up.xyz)), unit);
}

void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2. - 1.;
  vec3 from = seen(A.xyz), to = seen(B.xyz), near = corner.x < 0. ? from : to;
  vec2 way = normalize(to.xy - from.xy + vec2(1e-4, 0)), across = vec2(-way.y, way.x);
  vec2 at = near.xy + (corner.x * way + corner.y * across) * (1.12 * A.w * near.z + 2.);
  if (B.w == 1.) at = mix(C.xy, C.zw, 0.5 + 0.5 * corner);
  gl_Position = vec4(2. * at / size.xy - 1., 0, 1);
}`;

/** What is around: the base on a table, a lamp above, windows at the sides. */
const AROUND = `
float edge(vec2 p) { // of a point in the base's plane, how far it is from the base; negative within
  vec2 q = abs(p) - frame.xy - base.x + 0.6;
  return length(max(q, 0.)) + min(max(q.x, q.y), 0.) - 0.6;
}

float sheet(vec2 p, vec2 wide, float soft) { // a rectangle with soft edges
  vec2 q = 1. - smoothstep(wide - soft, wide + soft, abs(p));
  return q.x * q.y;
}

vec3 sky(vec3 p, vec3 ray, float blur) { // blur: how far rays of one pixel part
  vec3 light = mix(horizon.rgb, zenith.rgb, smoothstep(-0.1, 0.8, ray.y));
  vec2 above = p.xz + ray.xz * (22. - p.y) / max(ray.y, 0.05);
  light += lamp.rgb * sheet(above - vec2(-4, 9), vec2(12, 6), 2.5 + 22. * blur);
  float left = max(dot(ray, vec3(-0.8, 0, 0.6)), 0.01), right = max(dot(ray, vec3(0.96, 0, -0.28)), 0.01);
  vec2 pane = vec2(dot(ray, vec3(0.6, 0, 0.8)), ray.y) / left - vec2(0, 0.5);
  light += window.rgb * sheet(pane, vec2(0.32, 0.5), 0.1 + blur);
  vec2 strip = vec2(dot(ray, vec3(0.28, 0, 0.96)), ray.y) / right - vec2(0.1, 0.7);
  return light + window.rgb * sheet(strip, vec2(0.12, 0.75), 0.06 + blur);
}

vec3 wood(vec2 p, float grain) {
  float wave = sin(0.7 * p.x + 0.3 * p.y);
  return top.rgb * (1. + grain * sin(9. * p.y + 2.5 * wave) * sin(31. * p.y + 3. * wave)) * (1.15 - 0.0035 * dot(p, p));
}

float shade(vec3 p, vec3 ball, float r) { // how much of the light from above a ball keeps from a point of the base
  vec3 to = ball - p;
  float far = dot(to, to);
  return r > 0. ? min(0.9, 1.5 * r * r * to.y / (far * sqrt(far))) : 0.;
}
`;

/** A ball; C and D are the balls to the left and to the right: where in their plane, how large, and how the contact
 *  shines; E is what it mirrors of red, green and blue light. */
const BALL = `
vec3 around(vec3 p, vec3 ray, float blur) {
  vec3 q = p + ray * (frame.z - p.y) / min(ray.y, -1e-3);
  float light = (1. - shade(q, A.xyz, A.w)) * (1. - shade(q, vec3(C.xy, 0), C.z)) * (1. - shade(q, vec3(D.xy, 0), D.z));
  vec3 beyond = mix(table.rgb, horizon.rgb, smoothstep(4., 60., length(q.xz - p.xz)));
  float soft = 0.1 + 5. * blur;
  vec3 ground = mix(wood(q.xz, 0.) * light, beyond, smoothstep(-soft, soft, edge(q.xz)));
  soft = 0.01 + blur;
  return mix(ground, sky(p, ray, blur), smoothstep(-soft, soft, ray.y));
}

float meets(vec3 p, vec3 ray, vec3 ball, float r) { // how far along a ray a ball is met; 0 for never
  vec3 to = ball - p;
  float along = dot(to, ray), under = r * r - dot(to, to) + along * along;
  return r > 0. && along > 0. && under > 0. ? max(along - sqrt(under), 0.) : 0.;
}

float shine(vec3 p, vec3 ball) { // of the contact with another ball
  vec3 to = p - mix(A.xyz, vec3(ball.xy, 0), A.w / (A.w + ball.z));
  return exp(-5. * dot(to, to) / (A.w * A.w));
}

vec4 thing(vec3 o, vec3 ray, float pixel) {
  vec3 to = A.xyz - o, steel = E.rgb;
  float along = dot(to, ray), blur = 2. * along * pixel / A.w;
  vec3 aside = along * ray - to;
  float away = length(aside), cover = clamp(0.5 + (A.w - away) / (along * pixel), 0., 1.);
  vec3 n = normalize(aside - ray * sqrt(max(A.w * A.w - away * away, 0.))), p = A.xyz + A.w * n;
  vec3 onward = reflect(ray, n), left = vec3(C.xy, 0), right = vec3(D.xy, 0);
  // Another ball may be mirrored and, in it, once more what is around.
  float l = meets(p, onward, left, C.z), r = meets(p, onward, right, D.z), loss = 1.;
  if (l + r > 0.) {
    vec3 q = p + (l + r) * onward, m = normalize(q - (l > 0. ? left : right));
    onward = reflect(onward, m);
    loss = meets(q, onward, A.xyz, A.w) > 0. ? 0.2 : 0.8;
    p = q;
    blur *= 4.;
  }
  vec3 light = around(p, onward, blur) * loss * steel * mix(0.78, 1., pow(1. - max(dot(n, -ray), 0.), 5.));
  p = A.xyz + A.w * n;
  return vec4(light + glowing.rgb * (C.w * shine(p, C.xyz) + D.w * shine(p, D.xyz)), cover);
}`;

/** A piece of a bar, or of a string (C.w). Where bars are bent, around C.xy with radius C.z, straight pieces have the
 *  normals of the bend. */
const ROD = `
vec4 thing(vec3 o, vec3 ray, float pixel) {
  vec3 way = B.xyz - A.xyz, to = A.xyz - o;
  float long_ = length(way);
  vec3 axis = way / long_;
  float slant = dot(axis, ray);
  float along = clamp((dot(to, ray) * slant - dot(to, axis)) / max(1. - slant * slant, 1e-4), 0., long_);
  vec3 q = A.xyz + along * axis;
  float far = dot(q - o, ray), dot_ = far * pixel, r = max(A.w, 0.5 * dot_);
  vec3 aside = o + far * ray - q;
  float away = length(aside), cover = clamp(0.5 + (r - away) / dot_, 0., 1.);
  aside -= dot(aside, axis) * axis;
  vec3 n = normalize(aside + normalize(slant * axis - ray) * sqrt(max(r * r - dot(aside, aside), 0.))), p = q + r * n;
  if (C.z > 0.) n = normalize(p - vec3(C.xy + C.z * normalize(p.xy - C.xy), A.z));
  cover *= smoothstep(-0.02, 0.02, p.y - frame.z);
  vec3 onward = reflect(ray, n);
  vec3 light = sky(p, vec3(onward.x, 0.15 + abs(onward.y), onward.z), 2. * dot_ / r);
  light = mix(mix(table.rgb, top.rgb, 0.6), light, smoothstep(-0.6, 0., onward.y));
  light *= mix(0.7, 1., pow(1. - max(dot(n, -ray), 0.), 5.));
  return vec4(mix(light, string_.rgb, C.w), cover);
}`;

/** The base, and its shadow on what it stands on. */
const STAND = `
vec4 thing(vec3 o, vec3 ray, float pixel) {
  float down = min(ray.y, -1e-3);
  vec2 p = o.xz + ray.xz * (frame.z - o.y) / down, q = o.xz + ray.xz * (frame.z - base.y - o.y) / down;
  float upper = edge(p), sharp = 1. / fwidth(upper), near = 0., far = 1.;
  // Where, on its way through the base's thickness, the ray comes closest to it, if it can meet its side.
  for (int k = 0; k < 5 && upper * sharp > -1. && (upper - distance(p, q)) * sharp < 1.; k++) {
    float third = (far - near) / 3.;
    if (edge(mix(p, q, near + third)) < edge(mix(p, q, far - third))) far -= third; else near += third;
  }
  float least = min(edge(mix(p, q, 0.5 * (near + far))), upper);
  float cover = clamp(0.5 - least * sharp, 0., 1.), level = clamp(0.5 - upper * sharp, 0., 1.);
  vec3 above = wood(p, top.a) + horizon.rgb * mix(0.03, 0.5, pow(1. + ray.y, 5.));
  above += 0.5 * top.rgb * lamp.rgb * (1. - smoothstep(0., 0.12, abs(upper + 0.08)));
  float dark = table.a * pow(max(1. - max(edge(q), 0.) / 2.5, 0.), 3.);
  vec4 solid = vec4(mix(side.rgb * mix(1., 0.5, near), above, level), 1);
  return mix(vec4(0, 0, 0, dark), solid, cover);
}`;

const SHADOW = `
vec4 thing(vec3 o, vec3 ray, float pixel) {
  vec3 p = o + ray * (frame.z - o.y) / ray.y;
  vec2 from = (p.xz - A.xz) / (1.7 * (A.y - frame.z));
  return vec4(0, 0, 0, edge(p.xz) < 0. ? shade(p, A.xyz, A.w) * max(1. - dot(from, from), 0.) : 0.);
}`;

/** From the ray to the pixel. */
const MAIN = `
out vec4 colour;
void main() {
  vec2 place = (gl_FragCoord.xy / size.z - lens.yz) / lens.x;
  vec3 o = eye.xyz, ray = normalize(right.xyz * place.x + up.xyz * place.y - towards.xyz);
  vec4 c = thing(o, ray, 1. / (size.z * lens.x));
  // From linear light to values of the screen: highlights are compressed, and gamma is 2.
  colour = vec4(sqrt(c.rgb / (1. + 0.18 * c.rgb)), 1) * c.a;
}`;

/** Fragment shaders by the kinds of things. */
export const PROGRAMS = Object.fromEntries(Object.entries({ STAND, SHADOW, ROD, BALL })
  .map(([kind, thing]) => [kind, COMMON + AROUND + thing + MAIN]));
