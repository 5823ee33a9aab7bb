"""The page of a discovery: the law in words, what it is drawn through, the front, closure before and after."""

from boom_mj.report.discovery.page import write_discovery as write_discovery
