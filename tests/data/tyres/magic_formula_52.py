#!/usr/bin/env python3
"""A second implementation of Magic Formula 5.2, to compare the first with: writes car_52.csv.

From the equations of PAC2002 and MF-Tyre 5.2 as their handbooks have them, in the book's form (Pacejka, Tire and Vehicle
Dynamics, 2nd edition, 2006, section 4.3): slip as tan alpha, camber as sin gamma in side force, shifts and residual moment.
"""
import math
import pathlib
import random

here = pathlib.Path(__file__).parent
p = {}
section = ""
for line in (here / "car_52.tir").read_text().splitlines():
    line = line.split("$")[0].split("!")[0].strip()
    if line.startswith("["):
        section = line
    elif "=" in line and section not in ("[UNITS]", "[MODEL]", "[INERTIA]"):
        key, value = line.split("=")
        p[key.strip()] = float(value.replace("D", "E"))
R0, FN, V0 = p["UNLOADED_RADIUS"] / 1000, p["FNOMIN"] * 1000, 16.7
FZ0 = FN * p["LFZO"]


def of(key):
    return p.get(key, 0.0)


def sign(x):
    return -1.0 if x < 0 else 1.0


def sine(D, C, B, E, x):
    return D * math.sin(C * math.atan(B * x - E * (B * x - math.atan(B * x))))


def cosine(C, B, E, x):
    return math.cos(C * math.atan(B * x - E * (B * x - math.atan(B * x))))


def forces(Fz, kappa, alpha, gamma, Vx):
    d = Fz / FZ0 - 1
    a, s = math.tan(alpha), math.sin(gamma)
    gx, gy, gz, sz = gamma * p["LGAX"], s * p["LGAY"], gamma * p["LGAZ"], s * p["LGAZ"]
    Vc = abs(Vx) * math.hypot(1, a)
    cos_a = Vx / Vc
    # Longitudinal force.
    kx = kappa + (of("PHX1") + of("PHX2") * d) * p["LHX"]
    Dx = (of("PDX1") + of("PDX2") * d) * (1 - of("PDX3") * gx**2) * p["LMUX"] * Fz
    Cx = of("PCX1") * p["LCX"]
    Ex = min(1, (of("PEX1") + of("PEX2") * d + of("PEX3") * d**2) * (1 - of("PEX4") * sign(kx)) * p["LEX"])
    Kx = Fz * (of("PKX1") + of("PKX2") * d) * math.exp(of("PKX3") * d) * p["LKX"]
    Fx0 = sine(Dx, Cx, Kx / (Cx * Dx), Ex, kx) + Fz * (of("PVX1") + of("PVX2") * d) * p["LVX"] * p["LMUX"]
    Bxa = of("RBX1") * math.cos(math.atan(of("RBX2") * kappa)) * p["LXAL"]
    Exa = min(1, of("REX1") + of("REX2") * d)
    Fx = Fx0 * cosine(of("RCX1"), Bxa, Exa, a + of("RHX1")) / cosine(of("RCX1"), Bxa, Exa, of("RHX1"))
    # Lateral force.
    Ky = (of("PKY1") * FZ0 * math.sin(2 * math.atan(Fz / (of("PKY2") * FZ0))) * (1 - of("PKY3") * abs(gy)) * p["LKY"])
    SHy = (of("PHY1") + of("PHY2") * d) * p["LHY"] + of("PHY3") * gy
    SVy = Fz * ((of("PVY1") + of("PVY2") * d) * p["LVY"] + (of("PVY3") + of("PVY4") * d) * gy) * p["LMUY"]
    ay = a + SHy
    mu = (of("PDY1") + of("PDY2") * d) * (1 - of("PDY3") * gy**2) * p["LMUY"]
    Cy = of("PCY1") * p["LCY"]
    Ey = min(1, (of("PEY1") + of("PEY2") * d) * (1 - (of("PEY3") + of("PEY4") * gy) * sign(ay)) * p["LEY"])
    By = Ky / (Cy * mu * Fz)
    Fy0 = sine(mu * Fz, Cy, By, Ey, ay) + SVy
    Byk = of("RBY1") * math.cos(math.atan(of("RBY2") * (a - of("RBY3")))) * p["LYKA"]
    Eyk, SHyk = min(1, of("REY1") + of("REY2") * d), of("RHY1") + of("RHY2") * d
    SVyk = (mu * Fz * (of("RVY1") + of("RVY2") * d + of("RVY3") * s) * math.cos(math.atan(of("RVY4") * a)) *
            math.sin(of("RVY5") * math.atan(of("RVY6") * kappa)) * p["LVYKA"])
    Fy = Fy0 * cosine(of("RCY1"), Byk, Eyk, kappa + SHyk) / cosine(of("RCY1"), Byk, Eyk, SHyk) + SVyk
    # Moments.
    Mx = R0 * Fz * (of("QSX1") * p["LVMX"] - of("QSX2") * gamma + of("QSX3") * Fy / FN) * p["LMX"]
    My = -R0 * Fz * p["LMY"] * (of("QSY1") + of("QSY2") * Fx / FN + of("QSY4") * (Vx / V0)**4) * sign(Vx)
    at = a + of("QHZ1") + of("QHZ2") * d + (of("QHZ3") + of("QHZ4") * d) * sz
    ar = a + SHy + SVy / Ky

    def together(slip):
        return math.atan(math.hypot(math.tan(slip), Kx / Ky * kappa)) * sign(slip)

    Bt = (of("QBZ1") + of("QBZ2") * d + of("QBZ3") * d**2) * (1 + of("QBZ4") * gz + of("QBZ5") * abs(gz)) * p["LKY"] / p["LMUY"]
    Ct = of("QCZ1")
    Dt = Fz * R0 / FN * (of("QDZ1") + of("QDZ2") * d) * (1 + of("QDZ3") * gz + of("QDZ4") * gz**2) * p["LTR"]
    Et = min(1, (of("QEZ1") + of("QEZ2") * d + of("QEZ3") * d**2) *
             (1 + (of("QEZ4") + of("QEZ5") * sz) * 2 / math.pi * math.atan(Bt * Ct * at)))
    t = Dt * cosine(Ct, Bt, Et, together(at)) * cos_a
    Br = of("QBZ9") * p["LKY"] / p["LMUY"] + of("QBZ10") * By * Cy
    Dr = Fz * R0 * ((of("QDZ6") + of("QDZ7") * d) * p["LRES"] + (of("QDZ8") + of("QDZ9") * d) * sz) * p["LMUY"] * cos_a
    arm = R0 * (of("SSZ1") + of("SSZ2") * Fy / FN + (of("SSZ3") + of("SSZ4") * d) * gamma) * p["LS"]
    Mz = -t * (Fy - SVyk) + Dr * math.cos(math.atan(Br * together(ar))) + arm * Fx
    sigma_kappa = Fz * (of("PTX1") + of("PTX2") * d) * math.exp(-of("PTX3") * d) * R0 / FN * p["LSGKP"]
    sigma_alpha = (of("PTY1") * math.sin(2 * math.atan(Fz / (of("PTY2") * FZ0))) * (1 - of("PKY3") * abs(gy)) * R0 *
                   p["LFZO"] * p["LSGAL"])
    return Fx, Fy, Mx, My, Mz, t, sigma_kappa, sigma_alpha


random.seed(5)
with open(here / "car_52.csv", "w") as out:
    out.write("# Written by magic_formula_52.py.\n"
              "Fz,kappa,alpha,gamma,dpi,Vx,Fx,Fy,Mx,My,Mz,trail,sigma_kappa,sigma_alpha\n")
    for _ in range(300):
        at = (random.uniform(300, 9000), random.choice([0, 1, 1, 1]) * random.uniform(-1, 1)**3,
              random.choice([0, 1, 1, 1]) * 0.5 * random.uniform(-1, 1)**3, random.uniform(-0.1, 0.1),
              random.choice([-1, 1, 1]) * random.uniform(3, 45))
        row = at[:4] + (0,) + at[4:] + forces(*at)
        out.write(",".join(f"{x:.9g}" for x in row) + "\n")
