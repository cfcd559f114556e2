"""What to do about a fault, in the words of teaching books; by kind of remark and kind of stroke.

Several wordings stand for each, the fittest first, so that no two remarks of one assessment end alike.
"""

from __future__ import annotations

from collections.abc import Mapping

from rumu.values import Bilingual

Advice = tuple[Bilingual, ...]

BEGINNING = "起筆"
"""Stands for the kind of stroke where a fault is at its beginning."""

WHOLE: Mapping[str, Advice] = {
    "larger": (
        Bilingual(
            "收緊間架，四邊留出餘地。", "Draw the strokes closer together and leave room on all four sides."
        ),
    ),
    "smaller": (
        Bilingual(
            "放開手腕，主筆寫足，把間架撐開。", "Free the wrist and write the main stroke to its full length."
        ),
    ),
    "lean": (
        Bilingual(
            "先定中軸，豎畫垂直落下，重心自然扶正。",
            "Settle the axis first and let the verticals fall plumb.",
        ),
    ),
    "offset": (
        Bilingual(
            "下筆前先看範本第一筆離格邊多遠。",
            "Before you begin, see how far the master's first stroke is from the edge.",
        ),
    ),
    "wide": (
        Bilingual(
            "橫畫收短，豎畫伸足，字形寫長些。",
            "Draw the horizontals in and let the verticals run to their full length.",
        ),
    ),
    "narrow": (
        Bilingual(
            "橫畫向左右寫足，字形放寬。", "Let the horizontals run to their full length on both sides."
        ),
    ),
    "heavy": (
        Bilingual(
            "行筆提起三分，只用筆尖一段，不要壓到筆肚。",
            "Lift the brush and write with its tip, not with its belly.",
        ),
        Bilingual(
            "提按要分明：該提處提得起來。", "Tell lifting from pressing: lift where the master is thin."
        ),
    ),
    "thin": (
        Bilingual(
            "按得實些，讓筆毫鋪開，行筆不飄。",
            "Press until the hairs spread and keep the brush on the paper.",
        ),
        Bilingual(
            "中鋒鋪毫，筆力送到每一筆。", "Keep the tip in the middle of the stroke and the hairs spread."
        ),
    ),
    "squeeze": (
        Bilingual(
            "先定兩部的交界，寬的收，窄的放，各得其位。",
            "Settle first where the two parts meet; draw in the one and give way to the other.",
        ),
    ),
    "part_place": (
        Bilingual(
            "兩部寫成一個字：寫後一部之前，先看它從前一部的哪裡起。",
            "Before the second part, see where on the first one the master lets it begin.",
        ),
    ),
    "inner_place": (
        Bilingual(
            "先看框內四邊的白各有多少，再落筆。",
            "See first how much white the master leaves on each side of it.",
        ),
    ),
    "inner_large": (
        Bilingual(
            "框內的筆畫收小，四周留白要勻。",
            "Write what is inside smaller and leave the white around it even.",
        ),
    ),
    "inner_small": (
        Bilingual("框內的筆畫放大，不要縮在一角。", "Write what is inside larger; it must fill its frame."),
    ),
    "rough": (
        Bilingual(
            "懸腕勻速，一筆寫到底，中途不停。",
            "Hold the wrist free, keep an even pace and finish each stroke in one go.",
        ),
    ),
    "torn": (
        Bilingual(
            "筆毫蘸透理順再落紙，中鋒行筆，墨邊自然光潔。",
            "Soak and smooth the hairs first; with the tip in the middle the edges come out clean.",
        ),
    ),
    "dry": (
        Bilingual(
            "蘸足墨，行筆慢些，筆一乾就再蘸。",
            "Take more ink, go slower and dip again as soon as the brush runs dry.",
        ),
    ),
    "blot": (
        Bilingual(
            "蘸墨後在硯邊舔去餘墨，筆到處不要停住。",
            "Wipe the brush on the stone after dipping and do not let it rest.",
        ),
    ),
    "pressed": (
        Bilingual(
            "收筆輕頓即起，不要按住不放。",
            "Pause lightly at the end and lift at once; do not keep pressing.",
        ),
    ),
    "filled": (
        Bilingual(
            "墨少些，筆提起來寫，先看好留白再落筆。",
            "Take less ink, lift the brush, and look at the white before the black.",
        ),
    ),
    "open": (
        Bilingual(
            "寫框先看四角：豎與橫折的起筆相接，末橫寫到右邊封住。",
            "Look at the corners first: let the sides begin together and end the last stroke on one.",
        ),
    ),
    "pale": (Bilingual("墨磨濃些，水少些。", "Grind the ink thicker and use less water."),),
    "spacing": (
        Bilingual(
            "先看筆畫之間的白，再落下一筆。",
            "Look at the white between the strokes before you set down the next.",
        ),
    ),
    "tips": (
        Bilingual(
            "露鋒處輕入，出鋒處漸提，讓筆鋒聚在一點。",
            "Enter lightly where the tip shows, lift little by little where it leaves.",
        ),
    ),
    "extra": (Bilingual("範本此處留白，不要添筆。", "The master is blank there."),),
    "missing": (Bilingual("對照範本，補上這一筆。", "Compare with the master and write this stroke too."),),
    "no_hook": (
        Bilingual(
            "到鉤處先頓筆蓄勢，再提鋒快速鉤出。",
            "Pause and press where the hook begins, then flick it out on the tip.",
        ),
    ),
}
"""For the whole character and its ink."""

STROKES: Mapping[str, Mapping[str, Advice]] = {
    "displaced": {
        "橫": (
            Bilingual(
                "落筆前先看範本這一橫的高低，量準它與鄰筆的距離。",
                "Before you set it down, see how high the master's stands, and how far from its neighbours.",
            ),
        ),
        "豎": (
            Bilingual(
                "先看它對準上面哪一點，再往下寫。",
                "See which point above it is in line with, then write down.",
            ),
        ),
        "撇": (
            Bilingual(
                "看清撇從哪一筆、哪一處出，再下筆。", "See from which point of which stroke it leaves."
            ),
        ),
        "捺": (Bilingual("先定捺腳落在哪裡，再起筆。", "Settle where its foot will land before you begin."),),
        "點": (
            Bilingual(
                "點小而要緊，看它對著哪一筆。", "A dot is small but it matters: see which stroke it faces."
            ),
        ),
        "": (
            Bilingual(
                "先看它離全字的中線多遠。",
                "See first how far it is from the middle of the character.",
            ),
            Bilingual("看清它與鄰筆的距離再落筆。", "Measure its distance to its neighbour first."),
        ),
    },
    "stroke_angle": {
        "橫 clockwise": (
            Bilingual(
                "橫畫左低右高，行筆時稍往右上送。", "A horizontal rises a little: carry it up to the right."
            ),
        ),
        "橫 anticlockwise": (
            Bilingual(
                "橫勢不可太陡，手腕放平再行筆。", "Do not let it climb so steeply: keep the wrist level."
            ),
        ),
        "豎": (
            Bilingual(
                "豎要中鋒直下，肘隨筆移，不要只轉手腕。",
                "Write straight down with the tip in the middle and let the elbow follow.",
            ),
        ),
        "撇": (
            Bilingual(
                "先看範本的撇尖指向哪裡，再一路送出。",
                "See where the master's tip points and carry the stroke out that way.",
            ),
        ),
        "捺": (
            Bilingual(
                "先看捺腳落處，逆入平出，一波三折。",
                "See where its foot lands, enter against the stroke and leave level.",
            ),
        ),
        "點": (Bilingual("點有向背，先看它朝哪一邊。", "A dot faces one way: see which."),),
        "": (
            Bilingual(
                "落筆前在空中順範本的方向走一遍。",
                "Move the brush along the master's stroke in the air first.",
            ),
            Bilingual("起筆與收筆先定兩點，再連成一筆。", "Fix the two ends in your mind, then join them."),
        ),
    },
    "stroke_long": {
        "橫": (Bilingual("行到八分便頓筆回鋒。", "Pause and turn the tip back before the end."),),
        "豎": (Bilingual("下端提早頓住，收筆回鋒。", "Stop sooner at the foot and turn the tip back."),),
        "撇": (Bilingual("早些提筆出鋒，不要拖長。", "Lift sooner and let the tip leave."),),
        "捺": (Bilingual("捺腳早些頓筆，再平出。", "Press for the foot sooner, then leave level."),),
        "": (Bilingual("提早收筆，讓出位置。", "End it earlier and leave room."),),
    },
    "stroke_short": {
        "橫": (
            Bilingual("行筆到位，再頓筆回鋒。", "Carry it to its end, then pause and turn the tip back."),
        ),
        "豎": (
            Bilingual(
                "力送到底再收，不要半途提筆。", "Carry the force down to the foot and do not lift half-way."
            ),
        ),
        "撇": (
            Bilingual(
                "力送到撇尖才離紙，不可半途甩出。", "Carry it to its tip; do not flick it off half-way."
            ),
        ),
        "捺": (
            Bilingual("一路鋪毫，到捺腳再頓。", "Let the hairs spread on the way and press at the foot."),
        ),
        "點": (
            Bilingual("點也有起、行、收，寫足再離紙。", "A dot, too, begins, goes on and ends: finish it."),
        ),
        "": (Bilingual("送到位再收筆。", "Carry it to its end."),),
    },
    "sticks_out": {
        "橫": (
            Bilingual(
                "寫到與範本同長處就頓筆，不再往外送。", "Pause where the master's ends and go no farther."
            ),
        ),
        "豎": (Bilingual("寫到範本收筆的高度就收。", "End it at the height where the master's ends."),),
        "撇": (Bilingual("撇尖到了範本的位置就提筆。", "Lift where the master's tip leaves the paper."),),
        "捺": (
            Bilingual(
                "捺腳到位就平出，不要再拖。", "Leave level where the master's foot is; do not drag it on."
            ),
        ),
        BEGINNING: (
            Bilingual(
                "先看範本這一筆從哪裡起，再落筆。", "See where the master's begins before you set it down."
            ),
            Bilingual("起筆退進來些，不要出頭。", "Begin farther in, where the master does."),
        ),
        "": (
            Bilingual("寫到範本收筆處就收。", "Stop where the master's ends."),
            Bilingual("收筆處與範本比一比，早些收住。", "Compare its end with the master's and stop sooner."),
        ),
    },
    "stroke_heavy": {
        "": (
            Bilingual(
                "主筆重、副筆輕，這一筆要提起來寫。",
                "Main strokes are heavy, others light: lift the brush here.",
            ),
            Bilingual("行筆稍提，不要一按到底。", "Lift a little on the way."),
        ),
    },
    "stroke_thin": {
        "": (
            Bilingual(
                "入筆後按下去，鋪毫再行。", "After the entry press until the hairs spread, then go on."
            ),
            Bilingual("行筆按實，不要飄過。", "Press on the way and do not skim."),
        ),
    },
    "entry_heavy": {
        "": (
            Bilingual(
                "露鋒輕入，順勢再按，不必重頓。", "Let the tip enter lightly and press only as you go on."
            ),
            Bilingual(
                "起筆輕些，藏鋒不等於重按。", "Begin more lightly: to hide the tip is not to press hard."
            ),
        ),
    },
    "entry_light": {
        "": (
            Bilingual("逆鋒起筆，頓一頓再行。", "Enter against the stroke and pause before you go on."),
            Bilingual("藏鋒落筆，先按後行。", "Hide the tip: press first, then move."),
        ),
    },
    "exit_blunt": {
        "撇": (
            Bilingual("邊行邊提，筆尖最後離紙。", "Lift as you go, so that the tip leaves the paper last."),
        ),
        "捺": (
            Bilingual(
                "捺腳頓後平出，漸提漸收。",
                "After pressing for the foot, leave level and lift little by little.",
            ),
        ),
        "鉤": (
            Bilingual(
                "蹲鋒之後再鉤出，出鋒要快而尖。", "Crouch before the hook and flick it out to a point."
            ),
        ),
        "橫": (
            Bilingual(
                "收筆輕頓，提筆回鋒，不要按死。",
                "Pause lightly, lift and turn the tip back; do not press it dead.",
            ),
        ),
        "": (
            Bilingual("收筆時漸漸提鋒。", "Lift the brush little by little at the end."),
            Bilingual("收筆要提得起，鋒才回得來。", "Lift at the end, or the tip cannot turn back."),
        ),
    },
}
"""Kind of remark -> kind of stroke, '' for all others -> what to do."""


def for_stroke(kind: str, stroke: str) -> Advice:
    """What to do about a stroke; stroke: its kind in Chinese, with the way it turned where that matters."""
    advice = STROKES[kind]
    plain = stroke.split(" ", maxsplit=1)[0]
    # 橫折鉤 begins as a horizontal, 豎彎鉤 as a vertical
    special = (advice[k] for k in (stroke, plain, plain[:1]) if k and k in advice)
    return (*next(special, ()), *advice[""])
