#!/usr/bin/env python3
"""Reduces every Nastran deck of a folder and prints which become bodies, and why the others do not.

    bench/nastran_decks.py FOLDER [--program build/release/mimbre] [--timeout 120]

A node of a shell or a bar or three nodes of a solid are the interface. Decks whose materials have no density get one
(--density). Where a file of printed results (.f06) lies beside a free deck, the lowest elastic frequencies are
compared. Decks without a mesh of their own (parts to be included), of heat, fluids, rotational symmetry, large
strain or aerodynamics alone are no linear structures; the share is of those that are.
"""

import argparse
import collections
import json
import math
import os
import re
import subprocess
import sys
import tempfile

ENDINGS = (".bdf", ".dat", ".nas")
ELEMENTS = re.compile(
    r"^(CTETRA|CHEXA|CPENTA|CPYRAM?|CQUAD[48R]?|CTRIA[36R]|CBAR|CBEAM3?|CBEND|CROD|CONROD|CTUBE|CSHEAR|CBUSH|CELAS\d)$"
)
OTHER_PHYSICS = re.compile(
    r"^(CTRIAX6?|CQUADX8?|CQUADX|CPLST[NS]\d|PLSOLID|PLPLANE|CHACAB|CAABSF|CCONEAX|CFLUID\d|MATHP|MATHE|CGEN|ACMODL"
    r"|CELLBOX|CELLWNG|PFLUID)$"
)


CONTACT = re.compile(r"^(BCTABLE|BCTSET|BCONP|BCONTACT|BCTADD)$")


def lines_of(path, depth=0):
    try:
        text = open(path, encoding="latin-1").read().splitlines()
    except OSError:
        return
    for line in text:
        include = re.match(r"\s*include\s+['\"]?([^'\"$]+)", line, re.I)
        if include and depth < 5:
            yield from lines_of(os.path.join(os.path.dirname(path), include.group(1).strip()), depth + 1)
        else:
            yield line


def kind_of(path):
    """'' for a linear structure, else what it is."""
    cards = collections.Counter()
    control = []
    bulk = False
    for line in lines_of(path):
        if re.match(r"\s*begin\s+(bulk)?", line, re.I):
            bulk = True
        elif not bulk:
            control.append(line.split("$")[0].strip().upper())
        if line[:1] not in "$+* \t,":
            cards[re.split(r"[,\t]", line)[0][:8].strip().rstrip("*").strip().upper()] += 1
    solution = next((re.sub(r"\W+", " ", c[3:]).strip() for c in control if c.startswith("SOL")), "")
    if not any(ELEMENTS.match(card) for card in cards) or not cards["GRID"]:
        return "no mesh of its own"
    if any(OTHER_PHYSICS.match(card) for card in cards):
        return "fluid, rotational symmetry, plane strain, large strain or generated cards"
    if any(CONTACT.match(card) for card in cards):
        return "contact between parts"
    if solution.split(" ")[0] in ("153", "159") or any("ANALYSIS" in c and "HEAT" in c for c in control):
        return "heat"
    return ""


def is_free(path):
    return not any(re.match(r"\s*SPC\s*[=(]", line, re.I) for line in lines_of(path))


def printed_frequencies(path):
    """Hz, of the first table of real eigenvalues in the .f06 beside a deck."""
    base = os.path.splitext(path)[0] + ".f06"
    if not os.path.exists(base):
        return []
    found, inside = [], False
    for line in open(base, encoding="latin-1"):
        if "R E A L   E I G E N V A L U E S" in line:
            if found:
                break
            inside = True
        elif inside:
            words = line.split()
            if len(words) == 7 and words[0].isdigit() and words[1].isdigit():
                found.append(float(words[4]))
            elif found and line.startswith("1"):
                break
    return found


CORNERS = {"CQUAD4": 1, "CQUADR": 1, "CQUAD8": 1, "CTRIA3": 1, "CTRIAR": 1, "CTRIA6": 1, "CTETRA": 3, "CPENTA": 3}
CORNERS.update({"CHEXA": 3, "CPYRAM": 3, "CBAR": 1, "CBEAM": 1})


def first_element(path):
    """A node of a shell, else three of a solid, else one of a bar."""
    found = {}
    for line in lines_of(path):
        if line[:1] in "$+* \t,":
            continue
        if "," in line[:10]:
            fields = [field.strip() for field in line.split("$")[0].split(",")]
        else:
            text = line.split("$")[0].expandtabs(8)
            width = 16 if text[:8].strip().endswith("*") else 8
            fields = [text[:8].strip().rstrip("*")]
            fields += [text[i : i + width].strip() for i in range(8, 72, width)]
        name = fields[0].upper().rstrip("*")
        count = CORNERS.get(name)
        if count and name not in found:
            nodes = [field for field in fields[3 : 3 + count] if field.isdigit()]
            if len(nodes) == count:
                found[name] = nodes
    return next((found[name] for name in CORNERS if name in found), [])


def reduce(program, deck, body, timeout, more):
    nodes = body + ".txt"
    with open(nodes, "w") as file:
        file.write("\n".join(first_element(deck)))
    command = [program, "reduce", deck, "--interface", "element=nodes:" + nodes, "--no-cache", "--json"]
    command += ["-o", body] + more + ([] if "--modes" in more else ["--modes", "4", "--free-modes", "6"])
    command += ["--free-modes", "1"] if "--modes" in more else []
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    except subprocess.TimeoutExpired:
        return None, "takes longer than %g s" % timeout
    if done.returncode in (0, 4):
        return json.loads(done.stdout), ""
    message = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines() or ["?"]
    text = re.sub(r"^.*?error: ", "", message[0])
    return None, "%s%s" % (text[:150], " (and %d more)" % (len(message) - 1) if len(message) > 1 else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--program", default="build/release/mimbre")
    parser.add_argument("--timeout", type=float, default=120)
    options = parser.parse_args()
    decks = []
    for folder, _, names in os.walk(options.folder):
        decks += [os.path.join(folder, name) for name in names if name.lower().endswith(ENDINGS)]
    linear = reduced = 0
    reasons = collections.Counter()
    with tempfile.TemporaryDirectory() as scratch:
        body = os.path.join(scratch, "body.h5")
        for deck in sorted(decks):
            name = os.path.relpath(deck, options.folder)
            kind = kind_of(deck)
            if kind:
                print(f"-        {name}: {kind}")
                continue
            linear += 1
            result, why = reduce(options.program, deck, body, options.timeout, [])
            note, more = "", []
            if "density" in why:
                result, why = reduce(options.program, deck, body, options.timeout, more := ["--density", "7850"])
                note = " with --density"
            if "more modes" in why or "fewer modes" in why:
                result, why = reduce(options.program, deck, body, options.timeout, more + ["--modes", "1"])
            if result is None:
                print(f"refused  {name}: {why}", flush=True)
                reasons[re.sub(r"[-+.\d]+", "#", re.sub(r"'.*?'", "''", why))[:70]] += 1
                continue
            reduced += 1
            found = [f for f in result.get("free_frequencies_hz", []) if f]
            print(f"reduces  {name}{note}: {', '.join('%.5g Hz' % f for f in found[:3])}", flush=True)
            printed = printed_frequencies(deck)
            if printed and is_free(deck):
                elastic = [f for f in printed if f > 1e-3 * max(printed)][: len(found)]
                worst = max((abs(a / b - 1) for a, b in zip(found, elastic)), default=math.nan)
                print(f"         printed {', '.join('%.5g' % f for f in elastic)}: off by {100 * worst:.2g} % at most")
    print(f"\n{reduced} of {linear} linear structures reduce ({100 * reduced / max(linear, 1):.0f} %), of {len(decks)} files")
    for why, count in reasons.most_common(25):
        print(f"{count:5d}  {why}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
