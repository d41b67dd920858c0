#include "onboard.h"

Target controller_planned_lvlh(Vector r_N, Vector v_N)
{
    const double r = norm(r_N);
    return (Target){lvlh_axes(r_N, v_N), {0.0, -norm(cross(r_N, v_N)) / (r * r), 0.0}};
}
