"""Computes the light of a surface and of the floor: sun with shadows, sky, lamp.

Light is linear; 1 is the light that white paper reflects. Arguments here and in ``shading``:

camera   four rows: the position; the direction of sight through the raster's corner; the change of this direction from one
         sample to the next on its right; and to the next below. Directions have length 1 along the camera's axis.
sun      three rows of four: the map from a point to the sun's raster. The third row is the direction to the sun, in meters.
shadows  the nearness of the first surface that the sun sees, for each texel of its raster
floor    seven numbers: the height and the side of a cell of the grid [m], the lamp's position on the floor (x, y), and the
         color of the lamp's light. The color is below zero without a lamp.

Source: Blinn, Models of light reflection (SIGGRAPH 1977), for the highlight; Williams, Casting curved shadows on curved
surfaces (SIGGRAPH 1978), and Reeves et al., Rendering antialiased shadows with depth maps (SIGGRAPH 1987), for soft shadows.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import rint, sqrt
from ulna.kernels.render.raster import row
from ulna.kernels.spatial.vectors import add_scaled, dot, plus, scaled

SKY, GROUND, SUN, FRONT, HIGHLIGHT = 0.40, 0.20, 0.62, 0.14, 0.25  # amounts of light
SHADE = 0.58  # share of the light that a floor keeps in the shadow
PAPER, LINE, HEAVY_LINE = (0.80, 0.82, 0.85), (0.62, 0.65, 0.70), (0.42, 0.46, 0.52)  # colors of the floor, linear
AIR_LOW, AIR_HIGH = (0.93, 0.945, 0.96), (0.72, 0.79, 0.87)  # colors of the background, at the horizon and above
CELLS_A_SECTION = 6  # cells between two thick lines of the floor's grid, as on the page
LINE_WIDTH, HEAVY_WIDTH = 0.02, 0.04  # shares of a cell
NEAR_EDGE, FAR_EDGE = 15.0, 45.0  # cells from the base: the floor fades out between these distances
SOFT = 5  # texels: the width of a shadow's edge
LIFT = 0.004  # [m] height above a surface at which its shadow is computed, against self-shadowing
LAMP_REACH, LAMP_SHARE = 0.17, 0.9  # radius of the lamp's light on the floor [m], and its largest share of the floor's light


@kernel
def unit(a):
    """The vector a, of length 1."""
    return scaled(a, 1.0 / sqrt(dot(a, a)))


@kernel
def mixed(a, b, x):
    """a, and b as far as x goes from 0 to 1."""
    return add_scaled(scaled(a, 1.0 - x), x, b)


@kernel
def ramp(x, low, high):
    """0 below low, 1 above high, smooth between."""
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@kernel
def ray(camera, x, y):
    """The direction of sight through the place (x, y) of the raster."""
    return plus(row(camera, 1), plus(scaled(row(camera, 2), x), scaled(row(camera, 3), y)))


@routine
def sunlit(sun, shadows, p):
    """The visible share of the sun from a point, 0 to 1.

    It is the share of a square of texels around the point in which no surface is nearer to the sun.

    1. Map the point to the sun's raster. Outside the raster nothing blocks the sun.
    2. Test the corners and the middle of the square. If they agree, as they mostly do, that is the result.
    3. Otherwise test all texels. Texels on the sides of the square count by their part inside it, so that the edge is smooth.
    """
    height = dot(row(sun, 2), p) + sun[2, 3]
    x, y = dot(row(sun, 0), p) + sun[0, 3] - 0.5 * SOFT, dot(row(sun, 1), p) + sun[1, 3] - 0.5 * SOFT
    if not (x >= 0.0 and y >= 0.0 and x < shadows.shape[1] - SOFT - 1 and y < shadows.shape[0] - SOFT - 1):
        return 1.0
    i, j = int(y), int(x)
    open_sky = (shadows[i, j] <= height) + (shadows[i, j + SOFT] <= height) + (shadows[i + SOFT // 2, j + SOFT // 2] <= height)
    open_sky += (shadows[i + SOFT, j] <= height) + (shadows[i + SOFT, j + SOFT] <= height)
    if open_sky % 5 == 0:
        return open_sky / 5.0
    total = 0.0
    for m in range(SOFT + 1):
        for n in range(SOFT + 1):
            if shadows[i + m, j + n] <= height:
                total += side_part(m, y - i) * side_part(n, x - j)
    return total / (SOFT * SOFT)


@kernel
def side_part(m, offset):
    """The share of texel m of SOFT + 1 inside a square that begins at an offset within the first texel."""
    if m == 0:
        return 1.0 - offset
    return offset if m == SOFT else 1.0


@kernel
def surface_light(sun, shadows, sight, p, normal, color):
    """The light of a surface of a color at p, seen along ``sight``: the normal is turned to the side that is seen."""
    to_sun, to_eye, n = unit(row(sun, 2)), scaled(unit(sight), -1.0), unit(normal)
    if dot(n, to_eye) < 0.0:
        n = scaled(n, -1.0)
    direct = max(dot(n, to_sun), 0.0)
    if direct > 0.0:
        direct *= sunlit(sun, shadows, add_scaled(p, LIFT, n))
    diffuse = GROUND + (SKY - GROUND) * (0.5 + 0.5 * n[2]) + FRONT * max(dot(n, to_eye), 0.0) + SUN * direct
    gloss = max(dot(n, unit(plus(to_sun, to_eye))), 0.0) ** 32
    return plus(scaled(color, diffuse), scaled((HIGHLIGHT, HIGHLIGHT, HIGHLIGHT), gloss * direct))


@kernel
def air_light(sight):
    """The air behind everything, from the horizon upwards."""
    return mixed(AIR_LOW, AIR_HIGH, ramp(unit(sight)[2], -0.1, 0.7))


@routine
def floor_light(camera, sun, shadows, floor, x, y):
    """The floor behind a place of the raster, as far as it reaches; else the air.

    Lines of the grid cover a part of what a sample sees, so that they are smooth, and far ones melt into the paper.
    """
    sight, eye = ray(camera, x, y), row(camera, 0)
    drop = eye[2] - floor[0]
    if not (sight[2] < -1e-6 and drop > 0.0):
        return air_light(sight)
    away = -drop / sight[2]
    p, cell = add_scaled(eye, away, sight), floor[1]
    gone = ramp(sqrt(p[0] * p[0] + p[1] * p[1]) / cell, NEAR_EDGE, FAR_EDGE)
    if gone >= 1.0:
        return air_light(sight)
    color = grid_color(camera, sight, p, away, cell)
    light = lamp_light(floor, p, scaled(color, SHADE + (1.0 - SHADE) * sunlit(sun, shadows, p)))
    return mixed(light, air_light(sight), gone) if gone > 0.0 else light


@kernel
def grid_color(camera, sight, p, away, cell):
    """The color of the floor at p, ``away`` times the direction of sight from the eye."""
    right, down = row(camera, 2), row(camera, 3)
    wide, high = away * right[2] / sight[2], away * down[2] / sight[2]
    seen_x = abs(away * right[0] - wide * sight[0]) + abs(away * down[0] - high * sight[0])
    seen_y = abs(away * right[1] - wide * sight[1]) + abs(away * down[1] - high * sight[1])
    thin = max(cover(p[0], cell, LINE_WIDTH * cell, seen_x), cover(p[1], cell, LINE_WIDTH * cell, seen_y))
    section = CELLS_A_SECTION * cell
    heavy = max(cover(p[0], section, HEAVY_WIDTH * cell, seen_x), cover(p[1], section, HEAVY_WIDTH * cell, seen_y))
    return mixed(mixed(PAPER, LINE, thin), HEAVY_LINE, heavy)


@kernel
def lamp_light(floor, p, light):
    """The light of the floor at p, where the lamp shines on it too."""
    if floor[4] < 0.0:
        return light
    far = ((p[0] - floor[2]) * (p[0] - floor[2]) + (p[1] - floor[3]) * (p[1] - floor[3])) / (LAMP_REACH * LAMP_REACH)
    return mixed(light, (floor[4], floor[5], floor[6]), LAMP_SHARE / ((1.0 + far) * (1.0 + far)))


@kernel
def cover(x, spacing, width, seen):
    """The part of a stretch ``seen`` about x that a line covers, of lines at multiples of a spacing."""
    off = abs(x - spacing * rint(x / spacing))
    low, high = max(off - 0.5 * seen, -0.5 * width), min(off + 0.5 * seen, 0.5 * width)
    return max(high - low, 0.0) / max(seen, 1e-12)
