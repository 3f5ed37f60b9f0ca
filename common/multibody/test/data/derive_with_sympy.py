#!/usr/bin/env python3
"""Derives the matrices of descriptions with SymPy, by Lagrange's equations in full, linearised at the end.

    derive_with_sympy.py DESCRIPTION.toml... > sympy_matrices.json

Shares no code and no method with the product, which adds up Jacobians (Jourdain).  Needs Python 3.11 and SymPy;
the tests read only what it wrote.  For each description and each of M, P, Q, S, Sd, T (per Om^2), C, G (what sensors
read: C q'' + G q): {"parameter or 1": [[row, column, number], ...]}, the geometry being that of the file.
"""

import json
import sys
import tomllib

import sympy as sp


def derive(path):
    with open(path, "rb") as file:
        d = tomllib.load(file)
    q = sp.symbols(d["coordinates"], real=True)
    v = [sp.Symbol(str(x) + "_rate", real=True) for x in q]
    a = [sp.Symbol(str(x) + "_rate2", real=True) for x in q]
    parameters = {name: sp.Symbol(name, real=True) for name in d["parameter"]}
    known = {name: sp.Rational(str(value)) for name, value in d.get("geometry", {}).items()}
    names = parameters | known | {str(x): x for x in q}
    formula = lambda text: sp.nsimplify(sp.sympify(str(text), locals=names), rational=True)
    vector = lambda texts: sp.Matrix([formula(t) for t in texts])
    g = formula(d.get("gravity_m_s2", 9.81))
    rate = lambda x: sum((sp.diff(x, q[i]) * v[i] for i in range(len(q))), sp.Integer(0))
    rest = {x: 0 for x in list(q) + v + a}

    turn = {"x": lambda t: sp.Matrix([[1, 0, 0], [0, sp.cos(t), -sp.sin(t)], [0, sp.sin(t), sp.cos(t)]]),
            "y": lambda t: sp.Matrix([[sp.cos(t), 0, sp.sin(t)], [0, 1, 0], [-sp.sin(t), 0, sp.cos(t)]]),
            "z": lambda t: sp.Matrix([[sp.cos(t), -sp.sin(t), 0], [sp.sin(t), sp.cos(t), 0], [0, 0, 1]])}
    frames = {"ground": (sp.zeros(3, 1), sp.eye(3))}
    kinetic = potential = dissipation = sp.Integer(0)
    for body in d["body"]:
        origin, axes = frames[body.get("on", "ground")]
        r, R = origin + axes * vector(body["position"]), axes
        for axis, angle in zip(body.get("axes", ""), body.get("angles", [])):
            R = R * turn[axis](formula(angle))
        frames[body["name"]] = (r, R)
        mass = formula(body.get("mass", 0))
        r_rate = r.applyfunc(rate)
        cross = R.T * R.applyfunc(rate)
        omega = sp.Matrix([cross[2, 1], cross[0, 2], cross[1, 0]])
        xx, yy, zz = vector(body.get("inertia", [0, 0, 0]))
        xy, yz, zx = vector(body.get("products_of_inertia", [0, 0, 0]))
        inertia = sp.Matrix([[xx, -xy, -zx], [-xy, yy, -yz], [-zx, -yz, zz]])
        kinetic += (mass * r_rate.dot(r_rate) + (omega.T * inertia * omega)[0]) / 2
        potential += mass * g * r[2]

    points = {p["name"]: (frames[p.get("body", "ground")], vector(p["position"])) for p in d["point"]}
    place = lambda name: points[name][0][0] + points[name][0][1] * points[name][1]

    def stretch(one):
        if "stretch" in one:
            return formula(one["stretch"])
        apart = place(one["between"][0]) - place(one["between"][1])
        if "direction" in one:
            return vector(one["direction"]).dot(apart)
        return sp.sqrt(apart.dot(apart))

    u = [sp.Symbol("u_" + t["name"]) for t in d.get("tyre", [])]
    u_rate = [sp.Symbol("u_rate_" + t["name"]) for t in d.get("tyre", [])]
    rest |= {x: 0 for x in u + u_rate}
    tensions, stretches = [], {}
    loaded = sp.Integer(0)
    for s in d.get("spring", []):
        x = stretches[s["name"]] = stretch(s)
        f0 = sp.Symbol("f0_spring_" + s["name"])
        tensions.append(f0)
        away = x - x.subs(rest)
        loaded += f0 * away
        potential += formula(s["stiffness"]) * away**2 / 2
    for s in d.get("stabiliser", []):
        x = stretches[s["springs"][0]] - stretches[s["springs"][1]]
        potential += formula(s["stiffness"]) * (x - x.subs(rest)) ** 2 / 2
    for s in d.get("damper", []):
        dissipation += formula(s["damping"]) * rate(stretch(s)) ** 2 / 2
    for t, height, height_rate in zip(d.get("tyre", []), u, u_rate):
        z = place(t["point"])[2]
        f0 = sp.Symbol("f0_tyre_" + t["name"])
        tensions.append(f0)
        away = z - z.subs(rest) - height
        loaded += f0 * away
        potential += formula(t["stiffness"]) * away**2 / 2
        dissipation += formula(t.get("damping", 0)) * (rate(z) - height_rate) ** 2 / 2

    # Tensions at rest: of those that balance the weights the ones of the least squares.
    slopes = sp.Matrix([[sp.diff(loaded, x).subs(rest).diff(f0) for f0 in tensions] for x in q])
    weights = sp.Matrix([sp.diff(potential, x).subs(rest) for x in q])
    value = -slopes.pinv() * weights
    assert all(sp.simplify(x) == 0 for x in slopes * value + weights), "not in equilibrium"
    potential += loaded.subs(dict(zip(tensions, value)))

    equations = []
    for i in range(len(q)):
        momentum = sp.diff(kinetic, v[i])
        equations.append(sum((sp.diff(momentum, v[j]) * a[j] + sp.diff(momentum, q[j]) * v[j] for j in range(len(q))),
                             -sp.diff(kinetic, q[i]) + sp.diff(potential, q[i]) + sp.diff(dissipation, v[i])))
    slope = lambda expressions, symbols: sp.Matrix([[sp.diff(e, s).subs(rest) for s in symbols] for e in expressions])
    matrices = {"M": slope(equations, a), "P": slope(equations, v), "Q": slope(equations, q),
                "S": -slope(equations, u), "Sd": -slope(equations, u_rate)}

    # A mass on a rotor, small against all others: U = uc + j us goes round at the rate Om, and what goes round
    # pulls outward.  Its place adds r to the plane's centre; the force on the coordinates is -m r''.
    alpha = sp.Symbol("alpha")
    rotors = list(dict.fromkeys(p["rotor"] for p in d.get("unbalance", [])))
    T = sp.zeros(len(q), 2 * len(rotors))
    for plane in d.get("unbalance", []):
        uc, us = vector(plane["moment"])
        moment = sp.Matrix([uc * sp.sin(alpha) + us * sp.cos(alpha), 0, uc * sp.cos(alpha) - us * sp.sin(alpha)])
        pull = -moment.diff(alpha, 2)
        column = 2 * rotors.index(plane["rotor"])
        for i, x in enumerate(q):
            force = sp.expand(place(plane["point"]).diff(x).subs(rest).dot(pull))
            T[i, column] += force.coeff(sp.sin(alpha))
            T[i, column + 1] += force.coeff(sp.cos(alpha))
    matrices["T"] = T

    readings = []
    for s in d.get("sensor", []):
        r, direction = place(s["point"]), points[s["point"]][0][1] * vector(s["direction"])
        r_rate = r.applyfunc(rate)
        r_rate2 = r_rate.applyfunc(rate) + r_rate.jacobian(v) * sp.Matrix(a)
        readings.append(direction.dot(r_rate2 + sp.Matrix([0, 0, g])))
    matrices["C"], matrices["G"] = slope(readings, a), slope(readings, q)

    def by_parameter(m):
        parts = {}
        zero = {p: 0 for p in parameters.values()}
        for name, symbol in [("1", None)] + list(parameters.items()):
            part = m.subs(zero) if symbol is None else m.diff(symbol)
            assert not part.free_symbols, f"{path}: not affine in {name}"
            entries = [[i, j, float(part[i, j])] for i in range(m.rows) for j in range(m.cols) if part[i, j] != 0]
            if entries:
                parts[name] = entries
        return parts

    return {name: by_parameter(m) for name, m in matrices.items()}


def main():
    print(json.dumps({"source": f"derive_with_sympy.py, SymPy {sp.__version__}"})[:-1], end="")
    for path in sys.argv[1:]:
        name = path.rsplit("/", 1)[-1].removesuffix(".toml")
        parts = [f'  "{m}": {{\n' + ",\n".join(f'   "{p}": {json.dumps(e)}' for p, e in by.items()) + "\n  }"
                 for m, by in derive(path).items()]
        print(f',\n "{name}": {{\n' + ",\n".join(parts) + "\n }", end="", flush=True)
    print("}")


if __name__ == "__main__":
    main()
