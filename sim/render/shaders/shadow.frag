#version 330 core
in vec3 surface;
uniform float remaining;  // share of the light that an ambient-lit point still gets
layout(location = 0) out vec4 colour;

void main()
{
    colour = vec4(vec3(remaining), 1.0);
}
