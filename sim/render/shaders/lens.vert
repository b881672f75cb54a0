#version 330 core
// The lens in the vertex shader, per vertex: a pinhole with its distortion (equation 15, with a divisor and a thin prism
// where the lens has them) or an equidistant fisheye; then the camera matrix.

layout(location = 0) in vec3 position;  // mm, body frame
layout(location = 1) in vec3 normal;    // body frame
#ifdef INKED
layout(location = 2) in vec4 ink;       // colour on the far side of the pattern's edges
layout(location = 3) in vec2 body;      // x: index of the body
layout(location = 4) in vec2 edge;      // signed distances to the two pattern edges, mm
layout(location = 5) in vec4 paint;
#else
layout(location = 2) in vec2 body;
layout(location = 3) in vec4 paint;
#endif

const int MAX_BODIES = 32;
uniform mat4 T_camera_body[MAX_BODIES];
uniform vec3 light_in_body[MAX_BODIES];  // unit vectors towards the light
uniform vec2 light;                      // ambient, diffuse
uniform mat3 K;                          // pixels, with the half pixel between OpenCV's and OpenGL's origin added
uniform bool fisheye;
uniform vec4 radial;                     // k1, k2, k3; of a fisheye k1 to k4
uniform vec3 divisor;                    // k4, k5, k6
uniform vec2 tangential;                 // p1, p2
uniform vec4 prism;                      // s1 to s4
uniform float linear_from;               // radius (of a fisheye: angle) beyond which the lens is continued linearly
uniform vec2 image_size;                 // pixels
uniform vec2 depth_range;                // near, far, mm

flat out vec3 surface;  // a face has one normal and one paint
#ifdef INKED
flat out vec3 inked;
out vec2 distance_mm;
#endif

vec2 distort(vec2 p)
{
    float r = length(p);
    vec2 e = r > 0.0 ? p / r : vec2(1.0, 0.0);
    float s = min(r, linear_from);
    float s2 = s * s;
    float below = 1.0 + s2 * (divisor.x + s2 * (divisor.y + s2 * divisor.z));
    float scale = (1.0 + s2 * (radial.x + s2 * (radial.y + s2 * radial.z))) / below;
    float slope = (radial.x + s2 * (2.0 * radial.y + s2 * 3.0 * radial.z)
                   - scale * (divisor.x + s2 * (2.0 * divisor.y + s2 * 3.0 * divisor.z))) / below;
    vec2 decentred = vec2(2.0 * tangential.x * e.x * e.y + tangential.y * (1.0 + 2.0 * e.x * e.x),
                          tangential.x * (1.0 + 2.0 * e.y * e.y) + 2.0 * tangential.y * e.x * e.y);
    vec2 value = e * (s * scale) + s2 * (decentred + prism.xz + s2 * prism.yw);
    vec2 derivative = e * (scale + 2.0 * s2 * slope)
                    + 2.0 * s * (decentred + prism.xz + 2.0 * s2 * prism.yw);  // along the radius
    return value + (r - s) * derivative;
}

vec2 by_angle(vec3 X)
{
    float across = length(X.xy);
    float theta = atan(across, X.z);
    float s = min(theta, linear_from);
    float s2 = s * s;
    float radius = s * (1.0 + s2 * (radial.x + s2 * (radial.y + s2 * (radial.z + s2 * radial.w))));
    float slope = 1.0 + s2 * (3.0 * radial.x + s2 * (5.0 * radial.y + s2 * (7.0 * radial.z + s2 * 9.0 * radial.w)));
    return across > 0.0 ? X.xy / across * (radius + (theta - s) * slope) : X.xy / X.z;
}

void main()
{
    int index = int(body.x + 0.5);
    vec4 X = T_camera_body[index] * vec4(position, 1.0);
    vec3 pixel = K * vec3(fisheye ? by_angle(X.xyz) : distort(X.xy / X.z), 1.0);
    // A fisheye also sees what stands beside it, where X.z is no depth.
    float depth = fisheye ? length(X.xyz) : X.z;
    // Row 0 of the frame buffer is the top row of the picture, so that nothing is flipped on the way back.
    vec2 ndc = 2.0 * (pixel.xy / pixel.z) / image_size - 1.0;
    float near = depth_range.x;
    float far = depth_range.y;
    gl_Position = vec4(ndc * depth, ((far + near) * depth - 2.0 * far * near) / (far - near), depth);

    float shade = light.x + light.y * max(dot(normal, light_in_body[index]), 0.0);
    surface = paint.rgb * shade;
#ifdef INKED
    inked = ink.rgb * shade;
    distance_mm = edge;
#endif
}
