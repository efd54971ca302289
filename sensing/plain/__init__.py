"""The paper's algorithm as it stands (METHOD steps 1 to 9), for comparison."""
