"""What is told of a compiled filter: NAME_report.txt, costs, offers of kalmanq design.
"""
