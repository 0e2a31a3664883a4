"""scipy and CasADi on the benchmark stroke: `python3 python.py FIXTURES`. What is not installed is skipped, with a word.

Prints the lines of `benches/timing.rs`. Equations, error norm and fit: fixtures/bench/stroke.rs, fixtures/bench/fit.rs.
"""

import math
import os
import sys
import time

# One thread, as everybody else has.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

RTOL, ATOL = 1e-6, 1e-8
SIZE = (10.0, 0.2, 5.0, 5.0, 0.17, 0.07, 0.5, 1.0)
START = (10.2, 0.2, 2.462, 2.462, 0.02, 0.0, 0.1, 0.0)
SWITCH, POINTS = 100, 2501
K, LENGTH, VOLUME = 47.946330147, 0.17, 1e-5
A1 = math.pi / 4 * 0.04**2
A2 = A1 - math.pi / 4 * 0.02**2
RELIEF, REVERSING = 0.62 * 5e-6 * K, 0.62 * 8e-6 * K
SPEED = 0.62 * (math.pi / 4 * 0.0021**2) * K
GAP = math.pi * 0.04 * 2.7e-14 * 1e6 / (12 * 0.03 * 0.03)
# State and noise of each measured column, bounds and starts of the fit.
SENSORS = ((0, 0.02), (3, 0.02), (6, 0.02), (4, 1e-4), (5, 2e-3))
BOUNDS = ((0.2, 0.5, 0.05), (4.0, 1.5, 1.2))
STARTS = ((1.0, 1.0, 1.0), (0.5, 1.2, 1.1), (3.0, 0.7, 0.2))


def derivative(y, q, u, sqrt=math.sqrt, most=min, least=max):
    """The equations, over floats or over the symbols of CasADi."""
    pp, zr, ps, pa, x, v, pb, s = y

    def root(d):
        return d / sqrt(sqrt(d * d + 4e-4))

    b = 1400 * q[3]
    qr = zr * RELIEF * root(pp - 0.1)
    qpa = q[2] * s * REVERSING * root(pp - ps)
    qo = q[1] ** 2 * SPEED * root(most(ps - pa, 0.74))
    ql = q[0] ** 3 * GAP * (pa - pb)
    qbt = q[2] * s * REVERSING * root(pb - 0.1)
    d, e = least(x - LENGTH, 0.0), least(-x, 0.0)
    force = 5e7 * d - 5e7 * e + 5e4 * v * (most(1e4 * d, 1.0) + most(1e4 * e, 1.0))
    return (
        b / 5e-5 * (5.5e-3 / 60 - qr - qpa),
        (most(least(pp - 10, 0.0), 1.0) - zr) / 0.002,
        b / 2e-6 * (qpa - qo),
        b * (qo - ql - A1 * v) / (VOLUME + A1 * x),
        v,
        ((pa * A1 - pb * A2) * 1e6 - 2000 * q[4] * v - 3000 * q[5] - force) / 50,
        b * (A2 * v + ql - qbt) / (VOLUME + A2 * (LENGTH - x)),
        (u - s) / 0.015,
    )


def pieces(np):
    """Command, times and first output point of both pieces."""
    t = np.arange(POINTS) * 1e-3
    return (0.0, t[: SWITCH + 1], 0), (1.0, t[SWITCH:], SWITCH)


def line(what, who, runs, f, remark):
    """Times `f` by the processor time of this process and prints a figure; `remark` gets the last answer."""
    times = []
    for _ in range(runs):
        start = time.process_time()
        answer = f()
        times.append((time.process_time() - start) * 1e3)
    times.sort()
    print(f"{what}\t{who}\t{times[0]:.6f}\t{times[runs // 2]:.6f}\t{remark(answer)}", flush=True)


def table(np, path):
    return np.loadtxt(path, delimiter=",", skiprows=1)


def error(np, folder, solution):
    reference = table(np, f"{folder}/stroke_reference.csv")
    found = solution[np.rint(reference[:, 0] * 1e3).astype(int)]
    return f"{np.sqrt(np.mean(((found - reference[:, 1:]) / SIZE) ** 2)):.1e}"


def misfits(np, solution, measured):
    columns = [(solution[:, state] - measured[:, i + 1]) / sigma for i, (state, sigma) in enumerate(SENSORS)]
    return np.concatenate(columns)


def scipy_stroke(np, method, q):
    from scipy.integrate import solve_ivp

    solution = np.empty((POINTS, 8))
    y = np.array(START)
    for u, t, first in pieces(np):
        # Without the last bit of slack the end of the piece may lie past the last output point.
        solved = solve_ivp(
            lambda _, y: derivative(y, q, u), (t[0], t[-1]), y, method=method, t_eval=t, rtol=RTOL, atol=ATOL
        )
        if not solved.success:
            raise RuntimeError(solved.message)
        solution[first : first + len(t)] = solved.y.T
        y = solved.y[:, -1]
    return solution


def scipy_all(np, folder):
    import scipy
    from scipy.optimize import least_squares

    nominal = (1.0,) * 6
    for method, runs in (("LSODA", 7), ("Radau", 3)):
        who = f"scipy {method}"
        line("one stroke", who, runs, lambda: scipy_stroke(np, method, nominal), lambda y: f"{error(np, folder, y)}, version {scipy.__version__}")
    measured = table(np, f"{folder}/stroke_measured.csv")

    def misfit(theta):
        return misfits(np, scipy_stroke(np, "LSODA", (*theta, 1.0, 1.0, 1.0)), measured)

    for start in STARTS:
        # Differences wider than the tolerance of the integration, or they are noise.
        line(
            f"fit from {list(start)}",
            "scipy trf, LSODA",
            1,
            lambda: least_squares(misfit, start, bounds=BOUNDS, diff_step=1e-4, x_scale="jac"),
            lambda found: f"cost {found.cost:.1f}, {found.nfev} steps",
        )


def casadi_solvers(np, casadi, count):
    """An integrator for each piece, with the first `count` parameters free."""
    y, q = casadi.SX.sym("y", 8), casadi.SX.sym("q", count)
    values = casadi.vertsplit(q) + [1.0] * (6 - count)
    solvers = []
    for u, t, _ in pieces(np):
        f = derivative(casadi.vertsplit(y), values, u, casadi.sqrt, casadi.fmin, casadi.fmax)
        options = {"reltol": RTOL, "abstol": ATOL, "max_num_steps": 100000}
        problem = {"x": y, "p": q, "ode": casadi.vertcat(*f)}
        solvers.append(casadi.integrator("stroke", "cvodes", problem, float(t[0]), [float(t) for t in t[1:]], options))
    return solvers


def casadi_plain(np, solvers, q):
    solution = [np.array(START).reshape(8, 1)]
    for solver in solvers:
        solution.append(np.array(solver(x0=solution[-1][:, -1], p=q)["xf"]))
    return np.hstack(solution).T


def casadi_sensitive(np, casadi, count):
    """A function of the parameters that gives all states and their derivatives, by CVODES' forward sensitivities."""
    q = casadi.MX.sym("q", count)
    first, second = casadi_solvers(np, casadi, count)
    before = first(x0=START, p=q)["xf"]
    after = second(x0=before[:, -1], p=q)["xf"]
    states = casadi.horzcat(casadi.DM(START), before, after)
    slopes = casadi.jacobian(casadi.vec(states), q)
    return casadi.Function("sensitive", [q], [states, slopes], {"ad_weight": 0.0})


def casadi_all(np, folder):
    import casadi

    plain = casadi_solvers(np, casadi, 0)
    remark = lambda y: f"{error(np, folder, y)}, version {casadi.__version__}"
    line("one stroke", "CasADi CVODES", 15, lambda: casadi_plain(np, plain, []), remark)
    for count in (3, 6):
        sensitive = casadi_sensitive(np, casadi, count)
        line(f"{count} sensitivities", "CasADi CVODES", 3, lambda: sensitive([1.0] * count), lambda found: error(np, folder, np.array(found[0]).T))
    try:
        from scipy.optimize import least_squares
    except ImportError:
        print("skipped: fits with CasADi, which need scipy", file=sys.stderr)
        return
    measured = table(np, f"{folder}/stroke_measured.csv")
    solvers, sensitive = casadi_solvers(np, casadi, 3), casadi_sensitive(np, casadi, 3)

    def slopes(theta):
        by = np.array(sensitive(theta)[1]).reshape(POINTS, 8, 3)
        return np.concatenate([by[:, state] / sigma for state, sigma in SENSORS])

    def misfit(theta):
        return misfits(np, casadi_plain(np, solvers, theta), measured)

    for start in STARTS:
        line(
            f"fit from {list(start)}",
            "scipy trf, CasADi",
            1,
            lambda: least_squares(misfit, start, jac=slopes, bounds=BOUNDS, x_scale="jac"),
            lambda found: f"cost {found.cost:.1f}, {found.nfev} steps",
        )


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: python.py FIXTURES, the folder with stroke_reference.csv")
    try:
        import numpy as np
    except ImportError:
        print("skipped: scipy and CasADi, numpy is not installed", file=sys.stderr)
        return
    for name, run in (("scipy", scipy_all), ("casadi", casadi_all)):
        try:
            __import__(name)
        except ImportError:
            print(f"skipped: {name} is not installed", file=sys.stderr)
            continue
        run(np, sys.argv[1])


if __name__ == "__main__":
    main()
