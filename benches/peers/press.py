"""An independent press: a simulator of hydraulic records that shares nothing with borescope but the circuit.

    python3 press.py OUT.csv [--cycle 1..4] [--fault NAME=VALUE]... [--effect NAME=VALUE]... [--set NAME=VALUE]...
                     [--machine SEED] [--seed SEED] [--clean]

Pump, relief valve, proportional 4/3 valve, one-way throttle in the line of the rod side, cylinder with mass and friction, a load. The spool is a mass: second order, with
dead time. `--machine` draws what a data sheet does not say: every machine is another one. OUT.csv is the record, OUT.json what is true of it, press.toml the rig file. numba, where installed, makes it tenfold faster.

Sources: Merritt, Hydraulic Control Systems (1967), chapters 3, 5, 6; Wu, Burton, Schoenau, International Journal of Fluid Power 3 (2002), for orifices down to no flow;
Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994), for friction; Nykaenen, Esque, Ellman, PTMC (2000), for air.
"""

import argparse
import json
import math

import numpy as np
from scipy.integrate import solve_ivp

try:
    from numba import njit
except ImportError:
    def njit(f):
        return f

BAR, LPM, ATMOSPHERE = 1e5, 1 / 60000, 1.01325e5
DT = 0.005

# The machine as its data sheets have it, SI. What is 0 here and no fault of the data sheet is a hidden effect.
SHEET = {
    "displacement": 10e-6, "speed": 1450 / 60, "pump_loss": 0.0, "pump_slip": 0.0, "pump_droop": 0.0,
    "set_pressure": 160 * BAR, "relief_flow": 15 * LPM, "relief_over": 8 * BAR, "relief_lag": 4e-3,
    "valve_flow": 20 * LPM, "valve_drop": 10 * BAR, "opening": 1.0,
    "open_PA": 1.0, "open_PB": 1.0, "open_AT": 1.0, "open_BT": 1.0,
    "leak_PA": 0.0, "leak_PB": 0.0, "leak_AT": 0.0, "leak_BT": 0.0, "dead_band": 0.0,
    "frequency": 35.0, "damping": 0.85, "dead_time": 3e-3,
    "throttle_flow": 8 * LPM, "throttle_drop": 25 * BAR, "throttle": 1.0, "check_crack": 0.5 * BAR, "check_slope": 12 * LPM / BAR,
    "bore": 0.063, "rod": 0.036, "stroke": 0.4, "mass": 180.0, "viscous": 2500.0, "coulomb": 0.0, "stribeck": 0.0,
    "clearance": 0.0, "land": 0.02, "dead_A": 150e-6, "dead_B": 120e-6, "line_P": 300e-6, "line_T": 60e-6,
    "density": 865.0, "viscosity": 0.030, "bulk": 1.30e9,
    "air": 0.0, "ext_leak_A": 0.0, "ext_leak_B": 0.0, "ext_leak_P": 0.0, "line_A": 0.0, "line_B": 0.0, "hose_A": 0.0,
    "cushion": 0.0, "cushion_length": 0.03, "spring": 0.0, "contact": 0.0, "contact_at": 0.28,
    "offset_p_A": 0.0, "offset_p_B": 0.0, "offset_p_P": 0.0, "gain_q_P": 1.0, "gain_x": 1.0, "gain_p_A": 1.0,
    "lag_p_P": 0.0, "lag_p_A": 0.0, "lag_p_B": 0.0, "lag_x": 0.0, "lag_q_P": 5e-3, "late_x": 0.0,
}
# Units in which options are given and truths are written; everything else is a pure number.
UNITS = {
    "displacement": 1e-6, "pump_slip": LPM / BAR, "pump_droop": 1 / BAR, "set_pressure": BAR, "relief_over": BAR, "viscosity": 1e-3, "bulk": BAR,
    "clearance": 1e-3, "leak_PA": LPM / BAR, "leak_PB": LPM / BAR, "leak_AT": LPM / BAR, "leak_BT": LPM / BAR,
    "ext_leak_A": LPM / BAR, "ext_leak_B": LPM / BAR, "ext_leak_P": LPM / BAR, "line_A": BAR / LPM**2, "line_B": BAR / LPM**2, "hose_A": 1e-6 / BAR,
    "offset_p_A": BAR, "offset_p_B": BAR, "offset_p_P": BAR, "dead_time": 1e-3, "cushion_length": 1e-3, "contact": 1e6, "spring": 1e3,
    "lag_p_P": 1e-3, "lag_p_A": 1e-3, "lag_p_B": 1e-3, "lag_x": 1e-3, "lag_q_P": 1e-3, "late_x": 1e-3, "relief_lag": 1e-3, "throttle_drop": BAR, "valve_drop": BAR,
}
# One standard deviation of how a machine differs from its data sheet, relative.
SPREAD = {
    "displacement": 0.01, "set_pressure": 0.01, "relief_over": 0.15, "relief_lag": 0.2, "valve_drop": 0.04, "throttle_drop": 0.08, "open_PA": 0.015, "open_PB": 0.015,
    "open_AT": 0.015, "open_BT": 0.015, "viscous": 0.3, "dead_A": 0.08, "dead_B": 0.08, "bulk": 0.12, "viscosity": 0.04,
}
NOISE = {"p_P": 0.3, "p_A": 0.3, "p_B": 0.3, "x": 0.05, "q_P": 0.05, "F": 20.0}
DIGITS = {"p_P": 2, "p_A": 2, "p_B": 2, "x": 2, "q_P": 3, "F": 0}
HEAD = {"p_P": "bar", "p_A": "bar", "p_B": "bar", "x": "mm", "q_P": "L/min", "F": "N"}
NAMES = list(SHEET)
INDEX = {name: i for i, name in enumerate(NAMES)}
for _name, _i in INDEX.items():
    globals()["_" + _name] = _i

# Commands as (seconds, command at its begin, at its end), loads as corners (s, N) joined by straight lines; x at the start, m.
CYCLES = {
    1: ([(0.5, 0, 0), (4.0, 1, 1), (0.5, 0, 0), (2.5, -1, -1), (0.5, 0, 0), (3.0, 0.5, 0.5), (0.5, 0, 0), (2.2, -0.6, -0.6), (1.0, 0, 0), (2.5, 0.8, 0.8), (2.8, 0, 0)],
        [(0, 2000), (2.5, 2000), (3.5, 22000), (4.6, 22000), (5.0, 1500), (9, 1500), (10, 12000), (11.2, 12000), (11.6, -500), (20, -500)], 0.06),
    2: ([(0.5, 0, 0), (3.0, 0.7, 0.7), (0.5, 0, 0), (2.0, -0.5, -0.5), (0.5, 0, 0), (3.7, 1, 1), (1.3, 0, 0), (2.9, -1, -1), (0.6, 0, 0), (1.5, 0, 1), (2.0, 1, 0), (1.5, 0, 0)],
        [(0, 6000), (1.5, 6000), (2.5, 16000), (3.3, 16000), (3.9, 3000), (8.5, 3000), (9.2, 28000), (10.5, 28000), (11.2, 1000), (20, 1000)], 0.08),
    3: ([(0.5, 0, 0), (4.2, 0.6, 0.6), (0.7, 0, 0), (2.4, -0.8, -0.8), (0.6, 0, 0), (2.6, 1, 1), (0.5, -0.4, -0.4), (1.8, 0.9, 0.9), (1.0, 0, 0), (2.1, -0.7, -0.7), (3.6, 0, 0)],
        [(0, 1000), (2.5, 1000), (3.5, 18000), (4.8, 18000), (5.3, 4000), (9, 4000), (9.8, 9000), (12, 9000), (12.8, 20000), (13.8, 20000), (14.2, 500), (20, 500)], 0.05),
    4: ([(0.5, 0, 0), (4.4, 1, 1), (0.6, 0, 0), (2.7, -1, -1), (0.5, 0, 0), (3.4, 0.4, 0.4), (0.6, 0, 0), (2.0, -0.4, -0.4), (0.6, 0, 0), (2.4, 0.75, 0.75), (2.3, 0, 0)],
        [(0, 3000), (2.5, 3000), (3.5, 14000), (4.9, 14000), (5.3, 2000), (10.5, 2000), (11.4, 25000), (12.1, 25000), (12.6, 1000), (20, 1000)], 0.04),
}


@njit
def orifice(k, dp, bore, density, viscosity):
    """Flow of an orifice that passes k sqrt(dp) while turbulent; its coefficient falls with the flow number (Wu et al. 2002)."""
    size = abs(dp)
    number = bore * math.sqrt(2 * density * size) / viscosity
    root = math.sqrt(size) * math.tanh(number / 500.0) if number > 1e-6 else size * bore * math.sqrt(2 * density) / viscosity / 500.0
    return k * root * (1.0 if dp > 0 else -1.0)


@njit
def stiffness(p, bulk, air):
    """Bulk modulus of oil with free air at atmospheric pressure per volume, polytropic 1.4 (Nykaenen et al.)."""
    if air <= 0:
        return bulk
    total = max(p + ATMOSPHERE, 2000.0)
    gas = air * (ATMOSPHERE / total) ** (1 / 1.4)
    return (1 + gas) / (1 / bulk + gas / (1.4 * total))


@njit
def between(t, times, values):
    i = np.searchsorted(times, t, side="right") - 1
    if i < 0:
        return values[0]
    if i >= len(times) - 1:
        return values[-1]
    return values[i] + (values[i + 1] - values[i]) * (t - times[i]) / (times[i + 1] - times[i])


@njit
def held(t, times, values):
    i = np.searchsorted(times, t + 1e-9, side="right") - 1
    return values[max(i, 0)]


@njit
def edge(s, dead):
    return max(s - dead, 0.0) / (1 - dead)


@njit
def flows(y, q):
    """Flows through everything: P to A, P to B, A to T, B to T with their leaks, throttle and check valve (into B), in the lines."""
    pp, pa, pt, pb, s = y[0], y[1], y[2], y[3], y[7]
    rho, mu = q[_density], q[_viscosity]
    k = q[_opening] * q[_valve_flow] / math.sqrt(q[_valve_drop])
    out, back = edge(s, q[_dead_band]), edge(-s, q[_dead_band])
    qpa = orifice(k * q[_open_PA] * out, pp - pa, 2e-3, rho, mu) + q[_leak_PA] * (pp - pa)
    qbt = orifice(k * q[_open_BT] * out, pt, 2e-3, rho, mu) + q[_leak_BT] * pt
    qpb = orifice(k * q[_open_PB] * back, pp - pt, 2e-3, rho, mu) + q[_leak_PB] * (pp - pt)
    qat = orifice(k * q[_open_AT] * back, pa, 2e-3, rho, mu) + q[_leak_AT] * pa
    throttle = orifice(q[_throttle] * q[_throttle_flow] / math.sqrt(q[_throttle_drop]), pt - pb, 1.5e-3, rho, mu)
    check = q[_check_slope] * max(pt - pb - q[_check_crack], 0.0)
    return qpa, qpb, qat, qbt, throttle + check


@njit
def drop_flow(dp, k):
    """Flow through a line that takes k q |q| and a trace of laminar resistance, so that it is always defined."""
    r = 0.01 * BAR / LPM
    size = abs(dp)
    flow = (-r + math.sqrt(r * r + 4 * k * size)) / (2 * k)
    return flow if dp > 0 else -flow


@njit
def slope(t, y, q, ut, uv, ft, fv):
    """y: p_P, p_A, p_valveB, p_B, x, v, relief opening, spool, spool speed, p in chamber A, p in chamber B, lagged q_P."""
    pp, pa, pt, pb, x, v, over, s, sv = y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], y[8]
    qpa, qpb, qat, qbt, into_b = flows(y, q)
    d = np.zeros(12)
    area = math.pi / 4 * q[_bore] ** 2
    ring = area - math.pi / 4 * q[_rod] ** 2
    # Pump and relief valve; the poppet follows the overpressure.
    pump = q[_displacement] * q[_speed] * (1 - q[_pump_loss]) * (1 - q[_pump_droop] * pp) - q[_pump_slip] * pp
    relief = q[_relief_flow] * over / q[_relief_over] * math.sqrt(max(pp, 0.0) / (q[_set_pressure] + q[_relief_over]))
    d[6] = (max(pp - q[_set_pressure], 0.0) - over) / q[_relief_lag]
    d[0] = stiffness(pp, q[_bulk], q[_air]) / q[_line_P] * (pump - relief - qpa - qpb - q[_ext_leak_P] * pp)
    # Chambers: with a line in between where it resists.
    h = q[_clearance] / 2
    line_a, line_b = q[_line_A] > 0, q[_line_B] > 0
    ca, cb = (y[9] if line_a else pa), (y[10] if line_b else pb)
    gap = math.pi * q[_bore] * (h**3 * (ca - cb) / (12 * q[_viscosity] * q[_land]) - h * v / 2)
    va, vb = q[_dead_A] + area * x, q[_dead_B] + ring * (q[_stroke] - x)
    near = 20e-6
    in_a, in_b = qpa - qat - q[_ext_leak_A] * pa, into_b - q[_ext_leak_B] * pb
    capacity_a = va / stiffness(ca, q[_bulk], q[_air]) + q[_hose_A]
    if line_a:
        thru = drop_flow(pa - y[9], q[_line_A])
        d[1] = stiffness(pa, q[_bulk], q[_air]) / near * (in_a - thru)
        d[9] = (thru - gap - area * v) / capacity_a
    else:
        d[1] = (in_a - gap - area * v) / capacity_a
        d[9] = d[1]
    if line_b:
        thru = drop_flow(pb - y[10], q[_line_B])
        d[3] = stiffness(pb, q[_bulk], q[_air]) / near * (in_b - thru)
        d[10] = stiffness(y[10], q[_bulk], q[_air]) / vb * (thru + gap + ring * v)
    else:
        d[3] = stiffness(pb, q[_bulk], q[_air]) / vb * (in_b + gap + ring * v)
        d[10] = d[3]
    d[2] = stiffness(pt, q[_bulk], q[_air]) / q[_line_T] * (qpb - qbt - into_b)
    # Piston: friction with Stribeck, cushions at both ends, contact with the work, end stops that bounce little.
    friction = q[_viscous] * v + (q[_coulomb] + q[_stribeck] * math.exp(-(v / 0.008) ** 2)) * math.tanh(v / 1.5e-3)
    depth_out, depth_in = x - (q[_stroke] - q[_cushion_length]), q[_cushion_length] - x
    if depth_out > 0 and v > 0:
        friction += q[_cushion] * v * v * depth_out / q[_cushion_length]
    if depth_in > 0 and v < 0:
        friction -= q[_cushion] * v * v * depth_in / q[_cushion_length]
    stop = 0.0
    if x > q[_stroke]:
        stop = 6e7 * (x - q[_stroke]) + 1e5 * max(v, 0.0) * min((x - q[_stroke]) / 5e-5, 1.0)
    if x < 0:
        stop = 6e7 * x + 1e5 * min(v, 0.0) * min(-x / 5e-5, 1.0)
    contact = q[_contact] * max(x - q[_contact_at], 0.0) + q[_spring] * x
    d[4] = v
    d[5] = (area * ca - ring * cb - friction - stop - contact - between(t, ft, fv)) / q[_mass]
    # Spool: mass on a controlled spring, behind the dead time of its electronics.
    w = 2 * math.pi * q[_frequency]
    d[7] = sv
    d[8] = w * w * (held(t - q[_dead_time], ut, uv) - s) - 2 * q[_damping] * w * sv
    d[11] = (qpa + qpb - y[11]) / q[_lag_q_P] if q[_lag_q_P] > 0 else 0.0
    return d


def commands(cycle):
    """The command held from each of its times on, as a controller of 5 ms writes it; and the length."""
    times, values, t = [], [], 0.0
    for duration, begin, end in CYCLES[cycle][0]:
        n = round(duration / DT)
        for i in range(n if begin != end else 1):
            times.append(round(t + i * DT, 6))
            values.append(begin + (end - begin) * i / n)
        t += duration
    return np.array(times, float), np.array(values, float), round(t, 6)


def simulate(q, cycle):
    """Times, states at them and flow into the valve."""
    ut, uv, length = commands(cycle)
    corners, start = CYCLES[cycle][1], CYCLES[cycle][2]
    ft, fv = np.array([c[0] for c in corners], float), np.array([c[1] for c in corners], float)
    area = math.pi / 4 * q[_bore] ** 2
    ring = area - math.pi / 4 * q[_rod] ** 2
    pb = 20 * BAR
    pa = (pb * ring + fv[0] + (q[_spring] * start)) / area
    pump_flow = q[_displacement] * q[_speed]
    pp = q[_set_pressure] + q[_relief_over] * pump_flow / q[_relief_flow]
    y = np.array([pp, pa, pb, pb, start, 0, pp - q[_set_pressure], 0, 0, pa, pb, 0.0])
    # Rest before the record, so that it begins in whatever the machine settles to.
    breaks = [-1.0, 0.0] + [t + q[_dead_time] for t in ut[1:]] + list(ft)
    times = np.round(np.arange(0, length + DT / 2, DT), 6)
    breaks = sorted({b for b in breaks if b < times[-1]} | {times[-1]})
    out = np.zeros((len(times), 12))
    scale = np.array([1e5, 1e5, 1e5, 1e5, 1e-2, 1e-2, 1e5, 1e-1, 10.0, 1e5, 1e5, 1e-4])
    tried = 2e-5
    for a, b in zip(breaks[:-1], breaks[1:]):
        inside = times[(times >= a) & (times < b)] if b < times[-1] else times[times >= a]
        at = np.unique(np.append(inside, b))
        run = solve_ivp(slope, (a, b), y, "BDF", at, args=(q, ut, uv, ft, fv), rtol=1e-6, atol=1e-6 * scale, max_step=0.05, first_step=min(tried, b - a))
        assert run.success, run.message
        out[np.searchsorted(times, inside)] = run.y[:, np.searchsorted(at, inside)].T
        y = run.y[:, -1]
    through = np.array([sum(flows(row, q)[:2]) for row in out])
    return times, out, through, (ut, uv, ft, fv)


def lagged(times, values, lag):
    """First-order lag of a sensor, exact for straight lines between samples."""
    if lag <= 0:
        return values
    out, z = np.empty_like(values), values[0]
    decay = math.exp(-DT / lag)
    out[0] = z
    for i in range(1, len(values)):
        a, b = values[i - 1], values[i]
        rise = (b - a) / DT
        z = (z - a + rise * lag) * decay + b - rise * lag
        out[i] = z
    return out


def record(q, cycle, rng, clean):
    times, y, through, (ut, uv, ft, fv) = simulate(q, cycle)
    raw = {
        "p_P": lagged(times, y[:, 0], q[_lag_p_P]) / BAR + q[_offset_p_P] / BAR,
        "p_A": lagged(times, y[:, 1], q[_lag_p_A]) / BAR * q[_gain_p_A] + q[_offset_p_A] / BAR,
        "p_B": lagged(times, y[:, 3], q[_lag_p_B]) / BAR + q[_offset_p_B] / BAR,
        "x": lagged(times, np.interp(times - q[_late_x], times, y[:, 4]), q[_lag_x]) * 1e3 * q[_gain_x],
        "q_P": (y[:, 11] if q[_lag_q_P] > 0 else through) / LPM * q[_gain_q_P],
        "F": np.interp(times, ft, fv),
    }
    if not clean:
        raw = {name: values + NOISE[name] * rng.standard_normal(len(values)) for name, values in raw.items()}
    command = [held(t, ut, uv) for t in times]
    heads = ["t [s]"] + [f"{name} [{HEAD[name]}]" for name in raw] + ["u [-]"]
    rows = [f"{t:.3f}," + ",".join(f"{raw[n][i]:.{DIGITS[n]}f}" for n in raw) + f",{command[i]:.4f}" for i, t in enumerate(times)]
    return "\n".join([",".join(heads)] + rows) + "\n"


def main():
    ask = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ask.add_argument("out")
    ask.add_argument("--cycle", type=int, default=1, choices=sorted(CYCLES))
    for kind in ("fault", "effect", "set"):
        ask.add_argument("--" + kind, action="append", default=[], metavar="NAME=VALUE")
    ask.add_argument("--machine", type=int, default=0, help="0: the data sheet itself")
    ask.add_argument("--seed", type=int, default=1)
    ask.add_argument("--clean", action="store_true", help="without noise")
    given = ask.parse_args()
    q = dict(SHEET)
    rng = np.random.default_rng(1000 + given.machine)
    if given.machine:
        for name, spread in SPREAD.items():
            q[name] *= 1 + spread * max(-2.0, min(2.0, rng.standard_normal()))
        q["damping"], q["frequency"], q["dead_time"] = rng.uniform(0.6, 1.0), rng.uniform(25, 50), rng.uniform(1e-3, 6e-3)
        for name in ("p_A", "p_B", "p_P"):
            q["offset_" + name] = 0.03 * BAR * rng.standard_normal()
    changed = {}
    for kind in ("set", "fault", "effect"):
        for entry in getattr(given, kind):
            name, value = entry.split("=")
            if name not in SHEET:
                ask.error(f"{name}: none of {', '.join(NAMES)}")
            q[name] = float(value) * UNITS.get(name, 1.0)
            changed.setdefault(kind, {})[name] = float(value)
    text = record(np.array([q[name] for name in NAMES]), given.cycle, np.random.default_rng(given.seed), given.clean)
    with open(given.out, "w") as file:
        file.write(text)
    truth = {"cycle": given.cycle, "machine": given.machine, "seed": given.seed, **changed, "all": {n: q[n] / UNITS.get(n, 1.0) for n in NAMES}}
    with open(given.out.removesuffix(".csv") + ".json", "w") as file:
        json.dump(truth, file, indent=1)


if __name__ == "__main__":
    main()
