# SPDX-License-Identifier: GPL-3.0-or-later
# Validates JSON results against the schemas shipped with the program.
#     check_results.py SCHEMAS RESULT.json ...      these results
#     check_results.py SCHEMAS --run PROGRAM DATA   computes and checks one result of every kind
import json
import pathlib
import subprocess
import sys
import tempfile

import jsonschema

schemas = {}
for file in pathlib.Path(sys.argv[1]).glob("*.json"):
    schema = json.loads(file.read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    schemas[schema["title"]] = jsonschema.Draft202012Validator(schema)


def faults(file):
    result = json.loads(pathlib.Path(file).read_text())
    for error in schemas[result["schema"]].iter_errors(result):
        yield "{}: {}: {}".format(file, error.json_path, error.message[:200])


def computed(folder, program, data):
    own = data + "/models/two-mass-impact-pair.toml"
    hertz, newton = data + "/problems/hertz-damped.toml", data + "/problems/newton-elastic.toml"
    runs = [["models"]]
    for problem, start, end in [(newton, "0.94", "0.95"), (own, "1.09", "1.1")]:
        runs += [["orbit", problem, "--y", "impacts"],
                 ["continue", problem, "--from", end, "--to", start, "--y", "energy_lost"],
                 ["lyapunov", problem, "--periods", "2000"],
                 ["sweep", problem, "--from", start, "--to", end, "--step", "0.005", "--y", "impact_speed_max"],
                 ["attractors", problem, "--random", "20"],
                 ["attractors", problem, "--x", "-1:1:3", "--v", "-1:1:3"],
                 ["map", problem, "--param", "eta:{}:{}:3".format(start, end), "--param", "r:0.5:2:3"],
                 ["verify", problem],
                 ["trajectory", problem, "--periods", "2"],
                 ["poincare", problem, "--points", "10"]]
    runs += [["diagram", newton, "--from", "0.94", "--to", "0.95", "--step", "0.005"],
             ["verify", hertz, "--hard-limit"],
             ["locate", hertz, "--type", "PD", "--param", "eta", "--near", "0.92"],
             ["orbit", newton, "--period", "2", "--search"],
             ["orbit", data + "/models/rimless-wheel.toml"],
             ["lyapunov", data + "/models/relief-valve.toml", "--periods", "200"],
             ["diagram", newton, "--from", "0.94", "--to", "0.95", "--skeleton", "--time", "0.01"]]
    for number, run in enumerate(runs):
        file = "{}/{}.json".format(folder, number)
        done = subprocess.run([program, *run, "--quiet", "--json", file], capture_output=True, text=True)
        if done.returncode not in (0, 1):
            sys.exit("{}: {}".format(" ".join(run), done.stderr))
        yield file


with tempfile.TemporaryDirectory() as folder:
    files = list(computed(folder, *sys.argv[3:5])) if sys.argv[2] == "--run" else sys.argv[2:]
    found = [fault for file in files for fault in faults(file)]
    seen = {json.loads(pathlib.Path(file).read_text())["schema"] for file in files}
if sys.argv[2] == "--run":
    missing = set(schemas) - seen - {"graze.reproduce/1"}  # it takes minutes
    found += ["no result of " + name for name in sorted(missing)]
print("\n".join(found[:50]) or "{} results are as their schemas say".format(len(files)))
sys.exit(bool(found))
