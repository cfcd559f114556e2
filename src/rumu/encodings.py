"""The text of a file whose encoding nobody stated: Unicode, GB 18030, Big5 or Windows-1252, by what it says.

Unicode is told by its form. GB 18030 and Big5 read nearly each other's every byte, so a short text is told by
its characters: those that stand in everyday Chinese and in the two standards' first level speak for a
reading, rare ones, symbols and kana against it.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection
from dataclasses import dataclass

_NAMES = {
    "utf-8": "UTF-8",
    "utf-16-le": "UTF-16",
    "utf-16-be": "UTF-16",
    "utf-32-le": "UTF-32",
    "utf-32-be": "UTF-32",
    "gb18030": "GB 18030",
    "cp950": "Big5",
    "cp1252": "Windows-1252",
}
_MARKS = (  # byte order marks; that of UTF-32 begins as that of UTF-16
    (b"\xef\xbb\xbf", "utf-8"),
    (b"\xff\xfe\0\0", "utf-32-le"),
    (b"\0\0\xfe\xff", "utf-32-be"),
    (b"\xff\xfe", "utf-16-le"),
    (b"\xfe\xff", "utf-16-be"),
)
_ORDINARY = 1.0  # likelihood from which a text is ordinary Chinese
_WORD = 4  # letters from which a word of another alphabet is no accident
_SAMPLE = 200_000  # characters that are weighed
_FREQUENT = frozenset(
    "的一是了我不人在他有这上们来到时大地为子中你说生国年着就那和要她出也得里后自以会家可下而过天去能对小"
    "多然于心学么之都好看起发当没成只如事把还用第样道想作种开美总从无情己面最女但现前些所同日手又行意动方"
    "期它头经长儿回位分爱老因很给名法间斯知世什两次使身者被高已亲其进此话常与活正感见明问力理尔点文几定本"
    "公特做外孩相西果走将月十实向声车全信重三机工物气每并别真打太新比才便夫再书部水像眼等体却加电主界门利"
    "海受听表德少克代员许先口由死安写性马光白或住难望教命花结乐色更拉东神记处让母父应直字场平报友关放至张"
    "认接告入笑内英军候民岁往何度山觉路带万男边风解叫任金快原吃妈变通师立象数四失满战远格士音轻目条呢病始"
    "达深完今提求清王化空业思切怎非找片罗钱吗语元喜曾离飞科言干流欢约各即指合反题必该论交终林请医晚制球决"
    "传画保读运及则房早院量苦火布品近坐产答星精视五连司巴奇管类未朋且婚台夜青北队久乎越观落尽形影红爸百令"
    "周吧识步希亚术留市半热送兴造谈容极随演收首根讲整式取照办强石古华拿计您装似足双妻尼转诉米称丽客南领节"
    "衣站黑刻统断福城故历惊脸选包紧争另建维绝树系伤示愿持千史谁准联妇纪基买志静阿诗独复痛消社算义竟确酒需"
    "单治卡幸兰念举仅钟怕共毛句息這們來時說國著裡後會過對學麼發當沒還樣種開總從無動頭經長兒愛給間兩見問點"
    "幾實將聲車進話與親別氣機並書體卻電門聽員許難馬樂寫東處讓應場報關張認軍歲覺帶萬邊風師數條滿戰遠輕錢羅"
    "語題論離請醫終決傳畫讀運產視連類號觀盡紅識術隊熱興談極講辦強華計裝雙轉訴稱麗領節歷驚臉選緊爭維絕樹傷"
    "願準聯紀買靜詩獨復單義確蘭舉鐘遊費價圖剛腦響禮細專黃塊靈據眾筆備習務須試懷調廣蘇顯賽議夢錯參虧設線溫"
    "雖養際陽紙納驗夠嚴證飯導頓獲藝創區謝組館質續標圍護劇險煙幫漢聞資擊顧團聖園勞陳魚異寶權簡態級尋殺勝樓"
    "貴責較職"
)
"""The characters that stand most often in Chinese texts, simplified and traditional."""
_KNOWN = frozenset(
    "功官待究跟穿室易游程号居考突皮哪费倒价图具刚脑永歌响商礼细专黄块脚味灵改据般破引食仍存众注笔甚某沉血"
    "备习校默务土微娘须试怀料调广苏显赛查密议底列富梦错座参八除跑亮假印设线温虽掉京初养香停际致阳纸李纳验"
    "助激够严证帝饭忘趣支春集丈木研班普导顿睡展跳获艺六波察群皇段急庭创区奥器谢弟店否害草排背止组州朝封睛"
    "板角况曲馆育忙质河续哥呼若推境遇雨标姐充围案伦护冷警贝雪索剧啊船险烟依斗值帮汉慢佛肯闻唱沙局伯族低玩"
    "资屋击速顾泪洲团圣旁堂兵七露园牛哭旅街劳型烈姑陈莫鱼异抱宝权鲁简态级票怪寻杀律胜份汽右洋范床舞秘午登"
    "楼贵吸责例追较职属渐左录丝牙党继托赶章智冲叶胡吉卖坚喝肉遗救修松临藏担戏善卫药刘赵孙吴徐朱郭梁宋郑唐"
    "冯董萧曹袁邓傅沈彭吕卢蒋蔡贾丁魏薛余潘杜戴夏汪田姜姚谭邹熊陆孔崔康邱秦侯邵孟龙雷汤尹黎楷隶篆帖碑拓墨"
    "砚毫撇捺钩挑横竖折颜柳欧褚羲献芾轼禅臨範檔傑偉婷雅怡欣宇轩涵梓浩伟娜芳敏杰娟艳勇磊霞秀桂玉燕屬漸錄絲"
    "黨繼趕衝葉賣堅遺擔戲衛藥劉趙孫吳鄭馮蕭鄧呂盧蔣賈譚鄒陸龍湯隸硯鉤橫豎顏歐獻軾禪兄襄頫素徑註姓業評績材"
    "源授署件副档径评绩码二九零冠豪翔彥廷宥睿承宏玄宙洪荒盈昃辰宿寒暑秋冬閏餘雲騰結為霜崑岡劍巨闕珠珍柰菜"
    "芥薑鹹淡鱗潛羽鳥乃服裳虞陶弔伐罪殷垂拱臣伏戎羌遐邇壹率賓歸鳴鳳竹駒賴蓋髮恭惟鞠豈敢毀慕貞潔效良罔彼短"
    "靡恃覆欲悲染讚羔羊景賢端谷虛禍惡積緣慶尺璧寸陰競君曰敬孝竭忠則履薄夙凊馨盛川淵澄映辭篤誠慎宜榮籍優仕"
    "攝政甘棠益詠殊賤尊卑睦婦隨訓奉儀諸叔猶枝投磨箴規仁慈隱惻弗廉退顛沛匪逸疲守逐移操爵縻邑邙洛浮渭涇宮殿"
    "盤鬱飛禽獸彩仙丙舍傍啟甲帳楹肆筵席鼓瑟吹笙升階陛弁疑內達既墳典亦聚稿鍾漆壁府俠槐卿戶縣陪輦驅轂振纓祿"
    "侈駕肥策茂勒銘磻溪伊佐衡奄宅阜旦孰營桓匡濟弱扶傾綺惠武俊乂勿寔寧晉楚霸困途滅虢踐盟遵約韓弊煩刑翦頗牧"
    "宣威漠馳譽丹禹跡郡嶽宗恆岱云亭雁紫塞雞赤昆池碣鉅野洞曠綿邈巖岫杳冥於農茲稼穡俶載畝黍稷稅熟貢勸賞黜陟"
    "軻敦秉庶庸謙謹敕聆鑒貌辨貽厥嘉猷勉祗植省躬譏誡寵增抗殆辱恥皋疏誰逼閒寂寥散慮逍遙奏累遣慼歡招渠荷莽抽"
    "枇杷翠梧桐凋委翳飄颻鵾凌摩絳霄耽寓囊箱輶攸畏耳垣牆膳餐適腸飽飫烹宰飢厭糟糠戚舊糧妾御紡侍巾帷紈扇圓銀"
    "燭煒煌晝眠夕寐藍筍弦宴杯觴矯悅豫嫡嗣祭祀烝嘗稽顙拜悚懼恐惶牋牒審詳骸垢浴執涼驢騾犢駭躍超驤誅斬賊盜捕"
    "叛亡射遼丸嵇琴阮嘯恬倫鈞巧釣釋紛俗皆佳妙施淑姿顰妍矢催曦暉朗曜璇璣懸斡晦魄環薪祜綏劭矩俯仰廊廟束矜莊"
    "徘徊瞻眺孤陋寡愚蒙誚謂焉哉芬玲翰恩晴蓁芯瑀瑄筱筠鈺琪瑋翊祐柏郁珮瑜佩珊慧嬌娥嬋婉曉彤穎芷凱琳鎮瑞輝銓"
    "鋒錦鴻鵬虎豹駿祥禎祺壽財順旺昌隆泰豐裕浚淳瀚濤灝澤湘湖童涂卓喬翁詹柯饒倪尤巫江廖倉頡菊梅蓮桃櫻楓橘檸"
    "檬蘋窗簾樑柱燈籠爐灶碗筷碟茶壺鍋鏟掃帚拖鞋襪褲裙帽衫袖扣縫補織繡剪刀針匹棉麻貓狗兔鼠猴鴨鵝豬蝴蝶蜜蜂"
    "螞蟻蜻蜓蜘蛛詢遂旭邕鮮樞徵祝允鐸燮綬紹碩繇靖楊凝冰裴休逋仲淹熹徽瘦楨璐醴泉寺塔序勤乙瑛遷晨頌嶧鼎氏猛"
    "爨瘞鶴喪亂姪敘譜閣蜀苕膽賦骨摹架泥砂裱褙卷軸幅披冊頁询鲜枢农绥绍谦硕杨渊宠宫铭颂峄盘瘗鹤丧乱侄叙谱阁"
    "胆赋镇轴册页"
)
"""Others of modern texts, names and calligraphy, and of the Thousand Character Classic."""


@dataclass(frozen=True, slots=True)
class DecodedText:
    """text: without a byte order mark. encoding: its name, for people."""

    text: str
    encoding: str


def decode_text(data: bytes, *, words: Collection[str] = ()) -> DecodedText | None:
    """The text that bytes hold, None when they hold none.

    words: that are likely to stand in it, such as the names of columns; they speak for a reading.
    """
    for mark, codec in _MARKS:
        if data.startswith(mark):
            return _decoded(data[len(mark) :], codec)
    if b"\0" in data:
        readings = [one for codec in ("utf-16-le", "utf-16-be") if (one := _decoded(data, codec))]
        return max(readings, key=lambda one: sum(map(str.isascii, one.text[:_SAMPLE])), default=None)
    unicode = _decoded(data, "utf-8")
    if unicode is not None and _is_surely_unicode(unicode.text):
        return unicode
    codecs = ("gb18030", "cp950") if unicode else ("gb18030", "cp950", "cp1252")
    readings = [one for codec in codecs if (one := _decoded(data, codec))]
    best = max(readings, key=lambda one: _likelihood(one.text, words), default=None)
    likelihood = _likelihood(best.text, words) if best else 0.0
    if unicode is not None:
        return best if likelihood >= _ORDINARY else unicode
    return best if likelihood > 0 else _guess(data) or best


def _is_surely_unicode(text: str) -> bool:
    """Whether text that is UTF-8 in form can be nothing else.

    The two bytes of 水 in GB 18030 are also a letter of UTF-8, as are those of every fifth common character.
    """
    foreign = re.findall(r"[^\0-\x7f]+", text[:_SAMPLE])
    if any(character >= "\u0800" for run in foreign for character in run):
        return True
    alphabet = re.compile(r"[\u0386-\u03ce]+|[\u0401-\u0451]+")  # Greek, Cyrillic
    if sum(map(len, foreign)) >= _WORD and all(
        alphabet.fullmatch(run) and (run.islower() or run.isupper() or run.istitle()) for run in foreign
    ):
        return True
    beside = r"(?<=[A-Za-z])[\xc0-\u017f](?![^\0-\x7f])|(?<![^\0-\x7f])[\xc0-\u017f](?=[A-Za-z])"  # é of été
    return len(re.findall(beside, text[:_SAMPLE])) >= len(foreign)


def _decoded(data: bytes, codec: str) -> DecodedText | None:
    """The text in this encoding; None when it is none, or holds what no text does."""
    try:
        text = data.decode(codec).removeprefix("\ufeff")
    except UnicodeDecodeError:
        return None
    return None if re.search(r"[\0-\x08\x0e-\x1f\ufffe\uffff]", text) else DecodedText(text, _NAMES[codec])


def _guess(data: bytes) -> DecodedText | None:
    """What charset-normalizer takes it for: Japanese, Korean, Cyrillic and others."""
    from charset_normalizer import from_bytes

    found = from_bytes(data[:_SAMPLE]).best()
    if found is None:
        return None
    try:
        return DecodedText(data.decode(found.encoding), found.encoding)
    except UnicodeDecodeError:
        return None


def _likelihood(text: str, words: Collection[str]) -> float:
    """How much the characters beyond ASCII look like writing, in the mean; above 0 if they do."""
    sample = text[:_SAMPLE]
    foreign = re.findall(r"[^\0-\x7f]+", sample)
    letters = "".join(foreign)
    weights = sum(map(_weight, letters)) - 2.0 * sum(
        sum(map(_is_latin, run)) for run in foreign if len(run) > 1
    )
    known = sum(3.0 for word in words if not word.isascii() and word in sample)
    return known + weights / max(1, len(letters))


def _weight(character: str) -> float:
    """What one character speaks for the reading in which it stands."""
    if character in _FREQUENT:
        return 3.0
    if character in _KNOWN:
        return 2.0
    if _is_latin(character):  # é stands alone among letters of ASCII; in a wrong reading they stand together
        return 0.8
    if 0x4E00 <= ord(character) < 0xA000:
        return 0.5 if _is_first_level(character) else -1.0
    if unicodedata.category(character) in ("Po", "Ps", "Pe", "Pd", "Zs") or 0xFF00 <= ord(character) < 0xFF5F:
        return 0.5  # punctuation and full-width forms
    return -2.0


def _is_latin(character: str) -> bool:
    return 0xC0 <= ord(character) < 0x180 and character.isalpha()


def _is_first_level(character: str) -> bool:
    """Whether it is among the common characters of GB 2312 or of Big5."""
    gb = character.encode("gb2312", errors="ignore")
    big5 = character.encode("big5", errors="ignore")
    return b"\xb0\xa1" <= gb <= b"\xd7\xf9" or b"\xa4\x40" <= big5 <= b"\xc6\x7e"
