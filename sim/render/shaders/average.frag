#version 330 core
// The mean of a pixel's samples, rounded to the nearest level, halves up.

uniform sampler2D samples;
uniform int along;  // samples along each side of a pixel

out vec4 colour;

void main()
{
    ivec2 first = ivec2(gl_FragCoord.xy) * along;
    vec3 sum = vec3(0.0);
    for (int row = 0; row < along; ++row)
        for (int column = 0; column < along; ++column)
            sum += texelFetch(samples, first + ivec2(column, row), 0).rgb;
    colour = vec4(floor(sum * (255.0 / float(along * along)) + 0.501) / 255.0, 1.0);
}
