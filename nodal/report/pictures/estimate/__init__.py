"""Pictures that explain one estimate: what each camera saw, the shape in space, and what it rests on along its length."""
