#version 330 core
flat in vec3 surface;
layout(location = 0) out vec4 colour;

void main()
{
    colour = vec4(surface, 1.0);
}
