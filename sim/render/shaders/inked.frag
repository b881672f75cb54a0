#version 330 core
// Two colours that meet at printed edges. How much of a sample lies on either side follows from the signed distance to
// the edge over its change across the sample, so an edge's place is not rounded to the grid of samples.
flat in vec3 surface;
flat in vec3 inked;
in vec2 distance_mm;
layout(location = 0) out vec4 colour;

vec2 side(vec2 d)
{
    vec2 across = sqrt(dFdx(d) * dFdx(d) + dFdy(d) * dFdy(d));
    return clamp(2.0 * d / max(across, vec2(1e-9)), -1.0, 1.0);
}

void main()
{
    vec2 s = side(distance_mm);
    colour = vec4(mix(surface, inked, 0.5 + 0.5 * s.x * s.y), 1.0);
}
