#version 330 core
uniform vec3 shadow;  // the receiving part's paint in ambient light alone
layout(location = 0) out vec4 colour;

void main()
{
    colour = vec4(shadow, 1.0);
}
