"""What files of the drag-free loop say."""
