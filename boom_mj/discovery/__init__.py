"""Discovery: the law that no library has, as a short formula at one place of the machine."""

from boom_mj.discovery.answer import document as document
from boom_mj.discovery.discover import Discovery as Discovery
from boom_mj.discovery.discover import discover as discover
from boom_mj.discovery.writing import law_file as law_file
