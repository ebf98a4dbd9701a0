#!/bin/sh
# Grades a brain on an exercise, for continuous integration: result.json and result.xml (JUnit) are written in any case.
#
#     BAUDBOT=baudbot EXERCISE=wander BRAIN='exec:python brain.py' sh grade.sh
#
# The exit code is that of `baudbot grade`: 0 passed, 3 not passed, any other: it could not be graded.
set -u
status=0
"${BAUDBOT:-baudbot}" grade "$EXERCISE" --brain "$BRAIN" --junit result.xml --json --quiet >result.json || status=$?
# A summary for whoever reads the log.
python3 - <<'PYTHON' || true
import json

with open("result.json", encoding="utf-8") as file:
    graded = json.load(file)
print(f"{graded['exercise']}: {graded['verdict']}, {graded['points']:g} of {graded['points_of']:g} points")
for finding in graded["findings"]:
    print(f"- {finding}")
PYTHON
exit "$status"
