"""A mark: one simulated copy against its master, both from the package."""

import rumu
from rumu.gallery.starter import find_work, starter_samples

sample = starter_samples(work="regular-shui")[1]
mark = rumu.assess(sample.path, find_work(sample.work).path)

low, high = mark.interval
print(f"{sample.id} (simulated): {mark.score:.0f} of 100, between {low:.0f} and {high:.0f}, {mark.level}")
for name, value in mark.parts.items():
    print(f"  {name:<10} {value:.0f}")
for remark in mark.remarks:
    print(f"  {remark.en} {remark.zh}")
