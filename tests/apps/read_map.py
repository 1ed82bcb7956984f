# SPDX-License-Identifier: GPL-3.0-or-later
# Prints the contents of a map file, as read by h5py, as JSON.
import json
import sys

import h5py


def number(value):
    return value if value == value and abs(value) != float("inf") else None


with h5py.File(sys.argv[1]) as file:
    field = file["attractor"]
    names = {value: name for name, value in h5py.check_enum_dtype(field.dtype).items()}
    print(json.dumps({
        "schema": file.attrs["schema"],
        "options": json.loads(file.attrs["options"]),
        "units": file.attrs["units"],
        "parameters": {name: value for name, value in file["parameters"].attrs.items() if name != "long_name"},
        "dimensions": [field.dims[i][0].name for i in range(3)],
        "eta": file["eta"][:].tolist(),
        "r": file["r"][:].tolist(),
        "start": [[number(x) for x in row] for row in file["start"][:]],
        "follow": [name.decode() for name in file["follow"][:]],
        "flags": [field.attrs["flag_values"].tolist(), field.attrs["flag_meanings"].split()],
        "names": [names[value] for value in sorted(names)],
        "filters": [field.compression, field.shuffle, list(field.chunks)],
        "type": [[[names[x] for x in row] for row in layer] for layer in field[:]],
        "period": file["period"][:].tolist(),
        "impacts": file["impacts"][:].tolist(),
        "lambda_1": [[[number(x) for x in row] for row in layer] for layer in file["lambda_1"][:]],
        "standard_error": [[[number(x) for x in row] for row in layer] for layer in file["standard_error"][:]],
        "state": file["state"][:].tolist(),
        "y": {name: [[[number(x) for x in row] for row in layer] for layer in values[:]]
              for name, values in file.get("y", {}).items()},
    }))
